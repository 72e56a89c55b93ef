function name = sbf_name(id, kind)
% The MATLAB name of a variable of a file of this kind (files.md section 4).
  full = {'T', 'time'; 'FXT', 'fxtot'; 'RQ', 'rxyzq'; 'KDEF', 'kdform'; 'STIF', 'estiff'};
  k = find(strcmp(full(:, 1), id), 1);
  if strcmp(kind, 'ltv')
    name = id;
  elseif ~isempty(k)
    name = full{k, 2};
  else
    name = lower(id);
  end
  if ~isletter(name(1)), name = ['v', name]; end
end
