function spacar_build(folder)
% SPACAR_BUILD  Build the MEX file of spacar from within MATLAB or Octave.
%
%   spacar_build           in the folder of these files
%   spacar_build(folder)   in another one; put it on the path, before the folder of these files
%
% The same as `spacar matlab --build FOLDER` in a shell, for a MATLAB whose compiler is not on the path of the shell. MATLAB:
% needs a C compiler (mex -setup C). Octave: needs mkoctfile (Debian: octave-dev).
%
% See also spacar.
  here = fileparts(mfilename('fullpath'));
  if nargin < 1, folder = here; end
  folder = full_name(folder);
  if exist(folder, 'dir') ~= 7, mkdir(folder); end
  side = tempname();  % the compiler of Octave does not take folders with blanks
  mkdir(side);
  start = pwd();
  back = onCleanup(@() leave(start, side));
  copyfile(fullfile(here, 'spacar.c'), side);
  cd(side);
  if exist('OCTAVE_VERSION', 'builtin')
    [output, status] = mkoctfile('--mex', 'spacar.c');
    if status ~= 0, error('spacar:build', 'mkoctfile failed: %s', output); end
  else
    mex('spacar.c');
  end
  built = dir('spacar.mex*');
  if isempty(built), error('spacar:build', 'the compiler wrote no MEX file'); end
  for k = 1:numel(built), copyfile(built(k).name, folder); end
  rehash();
end

function leave(start, side)
% Back to the folder of the caller; the other one is removed.
  cd(start);
  names = dir(fullfile(side, 'spacar.*'));
  for k = 1:numel(names), delete(fullfile(side, names(k).name)); end
  rmdir(side);
end
