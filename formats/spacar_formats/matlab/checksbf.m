function check = checksbf(file)
% CHECKSBF  What is in a result file, and whether its bytes are sound.
%
%   checksbf(file)             prints the variables; a damaged file is an error
%   check = checksbf(file)     structure: file, kind, state ('complete', 'stopped early', 'being written'), steps,
%                              names, type (1 integer, 2 real, 3 text), rows, cols, isstep, damage (texts), sound
%
% Every checksum is verified: of preamble, directory and all steps. Where preamble or directory are wrong nothing can be
% listed, and that is an error (spacar:damaged) in both forms. FILE with or without extension.
%
% See also getfrsbf, repinsbf.
  [d, fid, guard] = sbf_directory(result_file(file, {'sbd', 'sbm', 'ltv'}), true);
  states = {'being written, or killed while writing', 'complete', 'stopped early'};
  damage = {};
  if d.steps < d.committed
    damage{end + 1} = sprintf('it has %d of the %d steps that it announces: cut off', d.steps, d.committed);
  elseif d.state == 1 && d.bytes > d.data + d.steps * d.stride
    damage{end + 1} = sprintf('%d bytes follow the last step of a complete file', d.bytes - d.data - d.steps * d.stride);
  end
  wrong = [];
  fseek(fid, d.data, 'bof');
  for k = 1:d.steps
    block = fread(fid, [1, d.stride], 'uint8=>uint8');
    trailer = double(typecast(block(end - 7:end), 'uint32'));
    if trailer(1) ~= mod(k, 2 ^ 32) || trailer(2) ~= sbf_crc32(block(1:end - 4)), wrong(end + 1) = k; end
  end
  if ~isempty(wrong)
    few = sprintf(', %d', wrong(1:min(end, 10)));
    damage{end + 1} = sprintf('wrong checksum or number of step %s (%d of %d steps)', few(3:end), numel(wrong), d.steps);
  end
  found = struct('file', d.file, 'kind', d.kind, 'state', states{d.state + 1}, 'steps', d.steps, 'names', {d.names}, ...
                 'type', d.type, 'rows', d.rows, 'cols', d.cols, 'isstep', d.isstep, 'damage', {damage}, ...
                 'sound', isempty(damage));
  if nargout > 0, check = found; return, end
  fprintf('%s: SBF version 1, kind %s, %s\n', d.file, d.kind, found.state);
  fprintf('%-15s %-9s %6s %6s  %s\n', 'Id', 'type', 'rows', 'cols', 'value');
  types = {'1 integer', '2 real', '3 text'};
  for k = [find(~d.isstep), 0, find(d.isstep)]
    if k == 0
      fprintf('%-15s %-9s %6d %6d  %d steps\n', 'TDEF', types{1}, d.steps, sum(d.isstep), d.steps);
    else
      shown = '';
      if ~d.isstep(k), shown = shortened(sbf_value(fid, d, k, []), d.type(k)); end
      fprintf('%-15s %-9s %6d %6d  %s\n', d.names{k}, types{d.type(k)}, d.rows(k), d.cols(k), shown);
    end
  end
  fprintf('number of steps: %d\n', d.steps);
  if isempty(damage)
    fprintf('all checksums are right\n');
  else
    error('spacar:damaged', '%s is damaged: %s', d.file, strjoin(damage, '; '));
  end
end

function text = shortened(value, type)
% The first values, column after column.
  if type == 3
    items = cellstr(value);
    shown = sprintf(' ''%s''', items{1:min(end, 6)});
  else
    items = value(:);
    shown = sprintf(' %.10g', items(1:min(end, 6)));
  end
  text = strtrim(shown);
  if numel(items) > 6, text = [text, ' ...']; end
end
