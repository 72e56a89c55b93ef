function [figure_, axes_, line_] = mechanism_figure(m, lines)
% A figure with one axes in it: the elements at the start in grey, LINES in blue, equal scales. Empty handles where there are
% no graphics (Octave without a toolkit), and, with a warning, where they fail: a picture is no reason to lose an analysis.
  figure_ = []; axes_ = []; line_ = [];
  if exist('OCTAVE_VERSION', 'builtin') && isempty(available_graphics_toolkits()), return, end
  try
    [figure_, axes_, line_] = drawn(m, lines);
  catch failure
    warning('spacar:graphics', 'no figure: %s', failure.message);
  end
end

function [figure_, axes_, line_] = drawn(m, lines)
  start = mechanism_lines(m, m.x(:, 1));
  [~, name] = fileparts(m.file);
  figure_ = figure('Name', name);
  axes_ = axes('Parent', figure_);
  plot3(axes_, start(1, :), start(2, :), start(3, :), '-', 'Color', [0.75 0.75 0.75]);
  hold(axes_, 'on');
  line_ = plot3(axes_, lines(1, :), lines(2, :), lines(3, :), '.-', 'Color', [0 0.3 0.7], 'LineWidth', 1.5);
  hold(axes_, 'off');
  axis(axes_, 'equal');
  if m.planar, view(axes_, 2); else, view(axes_, 3); end
  grid(axes_, 'on');
end
