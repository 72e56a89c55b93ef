function [message, identifier] = engine_error(status, errors, text)
% Message and identifier for a program that ended with a status other than 0.
  if isempty(errors)
    message = sprintf(['the program spacar could not be run (status %d): %s\nSet the environment variable ' ...
                       'SPACAR_COMMAND to its full name, setenv(''SPACAR_COMMAND'', ...), or make this folder with ' ...
                       'spacar matlab --build FOLDER'], status, strtrim(text));
    identifier = 'spacar:command';
    return
  end
  message = errors{1};
  for k = 2:numel(errors), message = sprintf('%s\n%s', message, errors{k}); end
  if status == 2, identifier = 'spacar:input'; else, identifier = 'spacar:failed'; end
end
