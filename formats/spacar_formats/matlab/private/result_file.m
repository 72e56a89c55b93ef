function file = result_file(name, kinds)
% Full name of a result file that is given with or without extension; kinds: the extensions to try, in this order.
% Throws spacar:notFound.
  if isempty(char(name)), error('spacar:notFound', 'the name of a result file is empty'); end
  name = full_name(name);
  [~, ~, extension] = fileparts(name);
  with = cell(1, numel(kinds));
  for k = 1:numel(kinds), with{k} = [name, '.', kinds{k}]; end
  if any(strcmpi(extension, {'.sbd', '.sbm', '.ltv', '.part', '.bak'}))
    candidates = [{name}, with];
  else
    candidates = [with, {name}];
  end
  for k = 1:numel(candidates)
    fid = fopen(candidates{k}, 'r');
    if fid >= 0
      fclose(fid);
      if exist(candidates{k}, 'dir') ~= 7, file = candidates{k}; return, end
    end
  end
  text = sprintf('%s not found', candidates{1});
  for k = 1:numel(candidates)
    if exist([candidates{k}, '.part'], 'file') == 2
      text = sprintf('%s; the run did not finish, its results are in %s.part', text, candidates{k});
      break
    end
  end
  error('spacar:notFound', '%s', text);
end
