function value = sbf_value(fid, d, k, steps)
% Value of the variable at place k of the directory, for a step variable at the steps (all when steps is []).
%
% A header variable, or one step: rows x cols. Several steps: one row a step, the values of a step column after column.
% Text: one line a char row, a matrix of lines padded with blanks.
  if d.isstep(k)
    if isempty(steps), steps = 1:d.steps; end
  elseif ~isempty(steps)
    error('spacar:step', '%s in %s has one value, not one for each step', d.names{k}, d.file);
  else
    fseek(fid, d.offset(k), 'bof');
    value = shaped(fid, d, k);
    return
  end
  wrong = find(steps < 1 | steps > d.steps | steps ~= round(steps), 1);
  if ~isempty(wrong)
    error('spacar:step', 'step %g does not exist: %s has %d steps', steps(wrong), d.file, d.steps);
  end
  size_ = d.rows(k) * d.cols(k);
  count = numel(steps);
  if count == 1
    fseek(fid, d.data + (steps - 1) * d.stride + d.offset(k), 'bof');
    value = shaped(fid, d, k);
  elseif size_ == 0 || count == 0
    value = zeros(count, size_);
  else
    value = zeros(size_, count);
    apart = diff(steps);
    fseek(fid, d.data + (steps(1) - 1) * d.stride + d.offset(k), 'bof');
    if all(apart == apart(1)) && apart(1) > 0
      value = fread(fid, [size_, count], sprintf('%d*double=>double', size_), apart(1) * d.stride - 8 * size_);
    else
      for n = 1:count
        fseek(fid, d.data + (steps(n) - 1) * d.stride + d.offset(k), 'bof');
        value(:, n) = fread(fid, size_, 'double');
      end
    end
    value = value.';
  end
end

function value = shaped(fid, d, k)
  size_ = d.rows(k) * d.cols(k);
  if d.type(k) == 3
    bytes = reshape(fread(fid, size_, 'uint8=>uint8'), d.cols(k), d.rows(k))';
    lines = cell(d.rows(k), 1);
    for n = 1:d.rows(k)
      lines{n} = regexprep(native2unicode(bytes(n, :), 'UTF-8'), ' +$', '');
    end
    value = char(lines);
  else
    kinds = {'int64', 'double'};
    value = reshape(fread(fid, size_, kinds{d.type(k)}), d.rows(k), d.cols(k));
  end
end
