function name = full_name(name)
% The name of a file with its folder: relative ones begin in the present folder, ~ is the home folder.
  name = char(name);
  if ~ispc() && (strcmp(name, '~') || strncmp(name, '~/', 2)), name = [getenv('HOME'), name(2:end)]; end
  absolute = any(name(1) == '/\') || (numel(name) > 1 && name(2) == ':');
  if ~absolute, name = fullfile(pwd(), name); end
end
