function result = spacar(mode, file, cconst)
% SPACAR  Run an analysis of a mechanism.
%
%   spacar(mode, file)               typed at the prompt or in a script: the arrays of the run are in the workspace
%   result = spacar(mode, file)      a structure with the arrays
%
% The arrays (x, xd, e, sig, lnp, le, time, m0, k0, ...) are those of LOADSBD and LOADSBM. Called from a function without
% an output argument, nothing of its workspace changes. A failing analysis is an error.
%
% MODE: 0 check, 1 forward dynamics, 2 inverse dynamics, 3 linearization along the result of mode 2, 4 forward
% dynamics with linearization, 7 eigenvalues, 8 buckling, 9 state space, 10 both 7 and 8. A minus sign means
% without a plot; no window is opened in either case.
% FILE: name of the input file, with or without .dat, with any folder. The log FILE.log and the results FILE.sbd,
% FILE.sbm, FILE.ltv are written beside it.
%
% Errors (identifier, message):
%   spacar:singularMass  'ERROR in subroutine SOLDYN: Singular mass matrix'
%   spacar:memory        'ERROR in subroutine PRPARE: Too many DOFs.'     there is no other limit than the memory
%   spacar:failed        the analysis failed: the sentence of the program; the log says more
%   spacar:input         the input file or the call is wrong: the sentence of the program
%   spacar:command       the program spacar was not found
% Warnings of the program are MATLAB warnings with the identifier spacar:engine.
%
% The program is `spacar`, or what the environment variable SPACAR_COMMAND says, or the one that built this folder.
% This file is the plain version and the help text; the MEX file beside it, where there is one, comes first.
%
% See also getfrsbf, loadsbd, loadsbm, getss, spavisual, stressbeam, spacar_build.
  if nargin < 2, error('spacar:arguments', 'SPACAR requires 2 or 3 input arguments'); end
  if nargin > 2 && ~isempty(cconst), error('spacar:arguments', 'the third argument CCONST is not supported'); end
  [message, identifier] = spacar_engine(mode, file);
  if ~isempty(message), error(identifier, '%s', message); end
  if nargout > 0, result = spacar_results(mode, file); return, end
  marker = 'spacar_is_called_from_here';  % seen by the caller only where it is the prompt, or a script that runs there
  assignin('base', marker, true);
  typed = evalin('caller', sprintf('exist(''%s'', ''var'')', marker)) == 1;
  evalin('base', ['clear ', marker]);
  if ~typed, return, end
  data = spacar_results(mode, file);
  names = fieldnames(data);
  try
    for k = 1:numel(names), assignin('base', names{k}, data.(names{k})); end
  catch
    warning('spacar:workspace', 'variables cannot be added to this workspace: write result = spacar(mode, file)');
  end
end
