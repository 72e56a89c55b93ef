function word = quoted_word(word, windows)
% A word of a command line, so that the shell hands it on as it stands: blanks, dollar signs, quotes, backslashes.
% Windows: names hold no quotation mark; a backslash before the closing one would escape it, so it is doubled.
  if windows
    if any(word == '"'), error('spacar:name', 'a name on Windows has no quotation mark: %s', word); end
    trailing = numel(word) - numel(regexprep(word, '\\+$', ''));
    word = ['"', word, repmat('\', 1, trailing), '"'];
  else
    word = ['''', strrep(word, '''', '''\'''''), ''''];
  end
end
