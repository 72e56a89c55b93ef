function data = loadsbd(file, varargin)
% LOADSBD  All variables of a .sbd result: coordinates, deformations, stresses, transfer functions, the tables of the mechanism.
%
%   data = loadsbd(file)                 a structure; data.time, ...
%   data = loadsbd(file, 'x', 't')       these variables only
%   loadsbd(file)                        puts them into the workspace of the caller
%
% FILE with or without extension. Shapes are those of GETFRSBF.
%
% See also getfrsbf, checksbf.
  found = load_result(file, 'sbd', varargin);
  if nargout > 0, data = found; return, end
  names = fieldnames(found);
  for k = 1:numel(names), assignin('caller', names{k}, found.(names{k})); end
end
