function data = load_result(name, kind, ids)
% All variables of a result (or those that are named) as fields of a structure, under their MATLAB names.
  [d, fid, guard] = sbf_directory(result_file(name, {kind}));
  if ~strcmp(d.kind, kind)
    error('spacar:kind', '%s is an .%s file, an .%s file is needed', d.file, d.kind, kind);
  end
  tell_incomplete(d);
  if isempty(ids), places = 1:numel(d.names); else, places = zeros(1, numel(ids)); end
  for n = 1:numel(ids)
    places(n) = sbf_find(d, ids{n});
    if places(n) == 0, error('spacar:id', 'ID not found: %s in %s', ids{n}, d.file); end
  end
  data = struct();
  for k = places, data.(sbf_name(d.names{k}, kind)) = sbf_value(fid, d, k, []); end
end
