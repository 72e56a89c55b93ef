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
  source = fullfile(here, 'spacar.c');
  if exist(folder, 'dir') ~= 7, mkdir(folder); end
  if exist('OCTAVE_VERSION', 'builtin')
    [output, status] = mkoctfile('--mex', '--output', fullfile(folder, 'spacar.mex'), source);
    if status ~= 0, error('spacar:build', 'mkoctfile failed: %s', output); end
  else
    mex('-outdir', folder, source);
  end
  rehash();
end
