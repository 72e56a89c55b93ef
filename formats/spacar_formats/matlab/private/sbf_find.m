function k = sbf_find(d, id)
% Place of a variable in the directory, 0 when it is not there; any case, under either of its two names.
  id = upper(strtrim(char(id)));
  k = find(strcmp(d.names, id), 1);
  if isempty(k)
    pairs = {'T', 'TIME'; 'FXT', 'FXTOT'; 'RQ', 'RXYZQ'; 'KDEF', 'KDFORM'; 'STIF', 'ESTIFF'};
    other = [pairs(strcmp(pairs(:, 1), id), 2); pairs(strcmp(pairs(:, 2), id), 1)];
    if ~isempty(other), k = find(strcmp(d.names, other{1}), 1); end
  end
  if isempty(k), k = 0; end
end
