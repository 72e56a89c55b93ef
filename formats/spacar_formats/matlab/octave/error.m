function error(varargin)
% ERROR  For Octave 7, which ends with a fault on an error structure whose stack has no field `column`: that of the
% structure is thrown without its stack. Every other call is handed on.
  if nargin == 1 && isstruct(varargin{1}) && isfield(varargin{1}, 'message')
    identifier = '';
    if isfield(varargin{1}, 'identifier'), identifier = varargin{1}.identifier; end
    builtin('error', struct('message', varargin{1}.message, 'identifier', identifier));
  else
    builtin('error', varargin{:});
  end
end
