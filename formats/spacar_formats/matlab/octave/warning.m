function varargout = warning(varargin)
% WARNING  For Octave 7, where warning('on', 'all') also turns on remarks on the syntax of its own files, and where
% `warning backtrace on` prints a warning. Every other call is handed on.
  if nargin == 2 && strcmp(varargin{1}, 'backtrace'), varargin = fliplr(varargin); end
  [varargout{1:nargout}] = builtin('warning', varargin{:});
  if numel(varargin) == 2 && strcmp(varargin{1}, 'on') && strcmp(varargin{2}, 'all')
    silent = {'Octave:language-extension', 'Octave:mixed-string-concat', 'Octave:array-as-logical', 'Octave:array-to-scalar', ...
              'Octave:shadowed-function', 'Octave:variable-switch-label', 'Octave:single-quote-string', ...
              'Octave:missing-semicolon', 'Octave:str-to-num'};
    for k = 1:numel(silent), builtin('warning', 'off', silent{k}); end
  end
end
