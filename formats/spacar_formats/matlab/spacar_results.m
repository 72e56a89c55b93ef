function data = spacar_results(mode, file)
% SPACAR_RESULTS  The arrays that a run has stored: a structure with those of FILE.sbd and, of modes with matrices, FILE.sbm.
%
%   data = spacar_results(mode, file)
%
% For spacar.m and the MEX file; call SPACAR. A check (mode 0) stores what it has; a run without results gives an empty structure.
  [folder, name, extension] = fileparts(char(file));
  if ~strcmpi(extension, '.dat'), name = [name, extension]; end
  stem = fullfile(folder, name);
  kinds = {'sbd'};
  if any(abs(mode) == [3 4 7 8 9 10]), kinds = {'sbd', 'sbm'}; end
  data = struct();
  for k = 1:numel(kinds)
    if exist([full_name(stem), '.', kinds{k}], 'file') ~= 2, continue, end
    found = load_result(stem, kinds{k}, {});
    names = fieldnames(found);
    for n = 1:numel(names), data.(names{n}) = found.(names{n}); end
  end
end
