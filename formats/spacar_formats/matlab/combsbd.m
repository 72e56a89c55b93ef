function steps = combsbd(varargin)
% COMBSBD  Put the steps of two or more .sbd results of one mechanism, in this order, into one file.
%
%   combsbd(file1, file2, ..., output)
%   combsbd(file1, file2, ..., output, '-force')     replaces an output that exists
%   steps = combsbd(...)                             number of steps of the output
%
% The header is that of the first file; times are kept. The program writes the output, whole or not at all.
%
% See also getfrsbf, checksbf.
  words = cellfun(@char, varargin, 'UniformOutput', false);
  option = {};
  if ~isempty(words) && strcmp(words{end}, '-force'), option = {'--overwrite'}; words(end) = []; end
  if numel(words) < 3, error('spacar:arguments', 'combsbd needs two or more files and the name of the output'); end
  words = cellfun(@full_name, words, 'UniformOutput', false);
  text = call_spacar([{'combsbd'}, option, {'--'}, words]);
  if nargout > 0, steps = str2double(regexp(text, '(\d+) steps\s*$', 'tokens', 'once')); end
end
