function data = loadsbm(file, varargin)
% LOADSBM  All variables of a .sbm result: the matrices of the linearized equations: m0, c0, d0, k0, n0, g0.
%
%   data = loadsbm(file)                 a structure; data.time, ...
%   data = loadsbm(file, 'm0', 'k0')    these variables only
%   loadsbm(file)                        puts them into the workspace of the caller
%
% FILE with or without extension. Shapes are those of GETFRSBF.
%
% See also getfrsbf, checksbf.
  found = load_result(file, 'sbm', varargin);
  if nargout > 0, data = found; return, end
  names = fieldnames(found);
  for k = 1:numel(names), assignin('caller', names{k}, found.(names{k})); end
end
