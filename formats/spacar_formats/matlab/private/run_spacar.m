function [status, text] = run_spacar(words, input)
% Run the program with these words, its standard input being a file or nothing; its exit status and what it printed.
%
% Which program: the environment variable SPACAR_COMMAND (as it stands, so it may hold words of its own), the file
% spacar_command.txt of a folder made by `spacar matlab --build`, else `spacar`.
  program = getenv('SPACAR_COMMAND');
  if isempty(program)
    program = 'spacar';
    stored = fullfile(fileparts(fileparts(mfilename('fullpath'))), 'spacar_command.txt');
    fid = fopen(stored, 'r');
    if fid >= 0
      program = quoted_word(strtrim(native2unicode(fread(fid, [1, Inf], 'uint8=>uint8'), 'UTF-8')), ispc());
      fclose(fid);
    end
  end
  line = program;
  for k = 1:numel(words), line = [line, ' ', quoted_word(words{k}, ispc())]; end
  if nargin > 1
    from = quoted_word(input, ispc());
  elseif ispc()
    from = 'NUL';
  else
    from = '/dev/null';
  end
  line = [line, ' 2>&1 <', from];
  if ~ispc() && ~exist('OCTAVE_VERSION', 'builtin')  % libraries of MATLAB are not those that Python was built with
    line = ['env -u LD_LIBRARY_PATH -u DYLD_LIBRARY_PATH ', line];
  end
  [status, text] = system(line);
end
