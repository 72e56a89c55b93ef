function text = call_spacar(words, input)
% Run a command of the program, with a text for it to read where there is one; hand on its warnings, throw its error;
% otherwise what it printed.
  if nargin > 1
    file = tempname();
    removed = onCleanup(@() delete(file));
    fid = fopen(file, 'w');
    fwrite(fid, unicode2native(input, 'UTF-8'));
    fclose(fid);
    [status, text] = run_spacar(words, file);
  else
    [status, text] = run_spacar(words);
  end
  [errors, warnings] = engine_messages(text);
  for k = 1:numel(warnings), warning('spacar:engine', '%s', warnings{k}); end
  if status ~= 0
    [message, identifier] = engine_error(status, errors, text);
    error(identifier, '%s', message);
  end
  text = strtrim(text);
end
