function [message, identifier] = spacar_engine(mode, file)
% SPACAR_ENGINE  Run the program for SPACAR and return the error to throw: two empty texts when all went well.
%
%   [message, identifier] = spacar_engine(mode, file)
%
% For spacar.m and the MEX file; call SPACAR. Where callers compare the message of an error with a text of the original,
% the message is that text; the sentence of the program, which says more, is printed before.
  message = ''; identifier = '';
  if ~(isnumeric(mode) && isscalar(mode) && mode == round(mode))
    message = 'MODE has an invalid value'; identifier = 'spacar:arguments'; return
  end
  if ~ischar(file) && ~isa(file, 'string') || isempty(file)
    message = 'FILENAME must be a text'; identifier = 'spacar:arguments'; return
  end
  file = char(file);
  if strncmp(file, '~', 1), file = full_name(file); end
  [status, text] = run_spacar({sprintf('%d', mode), '--', file});
  [errors, warnings] = engine_messages(text);
  for k = 1:numel(warnings), warning('spacar:engine', '%s', warnings{k}); end
  if status == 0, return, end
  [message, identifier] = engine_error(status, errors, text);
  original = {'singular mass matrix', 'ERROR in subroutine SOLDYN: Singular mass matrix', 'spacar:singularMass'
              'out of memory', 'ERROR in subroutine PRPARE: Too many DOFs.', 'spacar:memory'};
  for k = 1:size(original, 1)
    if ~isempty(strfind(message, original{k, 1}))
      fprintf('%s\n', message);
      message = original{k, 2}; identifier = original{k, 3};
      return
    end
  end
end
