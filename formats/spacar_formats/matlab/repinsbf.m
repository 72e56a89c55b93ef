function repinsbf(file, id, value, step)
% REPINSBF  Replace the value of one variable of a result file.
%
%   repinsbf(file, id, value)          a variable that has one value
%   repinsbf(file, id, value, step)    a variable that has one value per step
%
% The size must be the stored one; a vector may be a row or a column. The program writes a complete new file, with new
% checksums, that takes the place of the old one: a crash leaves the old or the new file, never a mixture.
%
% See also getfrsbf, checksbf.
  if nargin < 3, error('spacar:arguments', 'repinsbf needs a file, a variable and a value'); end
  words = {'repinsbf', result_file(file, {'sbd', 'sbm', 'ltv'}), char(id), '-'};
  if nargin > 3, words = [words, {'--at', sprintf('%d', step)}]; end
  call_spacar(words, as_json(value));
end

function text = as_json(value)
% Numbers with all their digits; a matrix as a list of rows, a vector as a list; lines of text.
  if iscellstr(value) || ischar(value) && size(value, 1) ~= 1
    lines = cellstr(value);
    for k = 1:numel(lines), lines{k} = quoted(lines{k}); end
    text = ['[', strjoin(lines(:)', ','), ']'];
  elseif ischar(value)
    text = quoted(value);
  elseif ~isnumeric(value) && ~islogical(value) || ~isreal(value)
    error('spacar:value', 'the new value must be real numbers or text');
  elseif isscalar(value)
    text = number(value);
  elseif isvector(value)
    text = list(value);
  else
    rows = cell(1, size(value, 1));
    for k = 1:numel(rows), rows{k} = list(value(k, :)); end
    text = ['[', strjoin(rows, ','), ']'];
  end
end

function text = list(values)
  parts = cell(1, numel(values));
  for k = 1:numel(parts), parts{k} = number(values(k)); end
  text = ['[', strjoin(parts, ','), ']'];
end

function text = number(value)
  value = double(value);
  if ~isfinite(value), error('spacar:value', 'the new value must be finite'); end
  text = sprintf('%.17g', value);
end

function text = quoted(text)
  text = ['"', strrep(strrep(text, '\', '\\'), '"', '\"'), '"'];
end
