function handle = spadraw(file)
% SPADRAW  Draw the mechanism of a .sbd result with a slider for the time.
%
%   handle = spadraw(file)     the figure ([] in Octave without graphics)
%
% Pictures and animations as files: `spacar draw` in a shell, or SPAVISUAL with two arguments.
%
% See also spavisual.
  m = mechanism_tables(file);
  [figure_, axes_, line_] = mechanism_figure(m, mechanism_lines(m, m.x(:, 1)));
  if ~isempty(figure_)
    title(axes_, time_of(m, 1));
    last = size(m.x, 2);
    if last > 1
      uicontrol(figure_, 'Style', 'slider', 'Units', 'normalized', 'Position', [0.1 0.01 0.8 0.04], 'Min', 1, 'Max', last, ...
                'Value', 1, 'SliderStep', [1, 10] / (last - 1), ...
                'Callback', @(slider, event) show(m, axes_, line_, round(get(slider, 'Value'))));
    end
  end
  if nargout > 0, handle = figure_; end
end

function show(m, axes_, line_, step)
  lines = mechanism_lines(m, m.x(:, step));
  set(line_, 'XData', lines(1, :), 'YData', lines(2, :), 'ZData', lines(3, :));
  title(axes_, time_of(m, step));
end

function text = time_of(m, step)
  text = sprintf('step %d, t = %.6g', step, m.t(step));
end
