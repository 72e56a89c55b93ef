function handle = spavisual(file, picture)
% SPAVISUAL  Draw the mechanism of a .sbd result: the elements at the first step in grey, at the last step in blue.
%
%   handle = spavisual(file)
%   handle = spavisual(file, mode)       also what the program draws of a run in this mode (7 vibration, 8 buckling modes, ...)
%   handle = spavisual(file, picture)    also a picture made by the program: name of a .png, .svg or .pdf file
%
% MATLAB: handle is the figure; its only child is the axes, so that handle.Children.XLabel.String = 'x' works.
% Octave, whose figures are numbers: a structure with the same fields, and Figure, the number ([] without graphics);
% Lines is what is drawn, 3 x n with NaN between the elements.
%
% See also spadraw, stressbeam.
  m = mechanism_tables(file);
  lines = mechanism_lines(m, m.x(:, end));
  [figure_, ~, ~] = mechanism_figure(m, lines);
  if nargin > 1 && isnumeric(picture)
    fprintf('%s\n', call_spacar({'visual', m.file, sprintf('%d', abs(picture))}));
  elseif nargin > 1
    call_spacar({'draw', m.file, '--output', full_name(picture)});
  end
  if nargout == 0, return, end
  if exist('OCTAVE_VERSION', 'builtin')
    label = struct('String', '');
    handle = struct('Figure', figure_, 'Lines', lines, ...
                    'Children', struct('XLabel', label, 'YLabel', label, 'ZLabel', label));
  else
    handle = figure_;
  end
end
