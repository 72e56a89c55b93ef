function value = getfrsbf(file, id, steps)
% GETFRSBF  Value of a variable of a result file.
%
%   value = getfrsbf(file, id)           at all steps
%   value = getfrsbf(file, id, steps)    at one step or several; the first is 1
%
% FILE: a .sbd, .sbm or .ltv file; without extension the first of these that is there. ID: name of the variable, any
% case; `time` and `t`, `fxtot` and `fxt`, `rxyzq` and `rq`, `kdform` and `kdef`, `estiff` and `stif` are the same.
% 'tdef' gives the number of steps.
%
% One value, one step, or a file of one step: the matrix as it is, a vector as a column. Several steps: one row a step,
% with the columns of the matrix one after the other, so that reshape(value(k, :), n, m) gives that of step k.
%
%   x = getfrsbf('crank.sbd', 'x');  K = getfrsbf('guide.sbm', 'k0', 1);
%
% Errors: spacar:id 'ID not found', spacar:step, spacar:notFound, spacar:damaged. The file is read directly; the checksums
% of its directory are verified, those of the steps by CHECKSBF.
%
% See also checksbf, loadsbd, loadsbm, getss.
  if nargin < 2, error('spacar:arguments', 'getfrsbf needs a file and a variable: getfrsbf(''crank.sbd'', ''x'')'); end
  if nargin < 3, steps = []; end
  [d, fid, guard] = sbf_directory(result_file(file, {'sbd', 'sbm', 'ltv'}));
  tell_incomplete(d);
  if strcmpi(strtrim(id), 'tdef') && isempty(steps), value = d.steps; return, end
  k = sbf_find(d, id);
  if k == 0
    text = sprintf('ID not found: %s in %s', id, d.file);
    if any(strcmpi(strtrim(id), {'dx', 'de', 'd2x', 'd2e', 'dxc', 'dec'}))
      text = [text, '; transfer functions are stored on request: OUTLEVEL 0 1 (dx, de), 0 2 (d2x, d2e) or 0 3 (all)'];
    end
    error('spacar:id', '%s', text);
  end
  value = sbf_value(fid, d, k, steps);
end
