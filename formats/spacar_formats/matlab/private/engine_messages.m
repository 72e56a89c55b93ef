function [errors, warnings] = engine_messages(text)
% The errors and warnings in what the program printed, each a text; indented lines belong to the one above.
  lines = regexp(text, '\r?\n', 'split');
  errors = {}; warnings = {}; last = '';
  for k = 1:numel(lines)
    line = lines{k};
    if strncmp(line, 'error: ', 7)
      errors{end + 1} = line(8:end); last = 'error';
    elseif strncmp(line, 'warning: ', 9)
      warnings{end + 1} = line(10:end); last = 'warning';
    elseif strncmp(line, '  ', 2) && strcmp(last, 'error')
      errors{end} = sprintf('%s\n%s', errors{end}, line);
    elseif strncmp(line, '  ', 2) && strcmp(last, 'warning')
      warnings{end} = sprintf('%s\n%s', warnings{end}, line);
    else
      last = '';
    end
  end
end
