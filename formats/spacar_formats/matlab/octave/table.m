function text = table(varargin)
% TABLE  For Octave 7, which has none: columns as text for DISP. table(column, ..., 'VariableNames', names).
  k = find(cellfun(@(word) ischar(word) && strcmp(word, 'VariableNames'), varargin), 1);
  if isempty(k) || numel(varargin) ~= k + 1 || numel(varargin{k + 1}) ~= k - 1
    error('Octave:undefined-function', 'table: only table(column, ..., ''VariableNames'', names) is provided for Octave');
  end
  text = [sprintf('  %12s', varargin{k + 1}{:}), sprintf('\n')];
  for row = 1:size(varargin{1}, 1)
    for column = 1:k - 1
      value = varargin{column}(row, :);
      if iscell(value), value = value{1}; end
      if ~ischar(value), value = strtrim(sprintf('%g ', value)); end
      text = [text, sprintf('  %12s', value)];
    end
    text = [text, sprintf('\n')];
  end
end
