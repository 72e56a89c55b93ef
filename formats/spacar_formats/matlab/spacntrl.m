function output = spacntrl(file, kpfun)
% SPACNTRL  Add a proportional controller to the time-varying system of an .ltv result.
%
%   output = spacntrl(file, kpfun)     writes FILEkp.ltv and gives its name
%
% KPFUN: a function or its name. It is called with -1 first, then with every step 1, 2, ..., and returns KP, a square
% matrix with a row for every nominal input (NNOM). KP enters the stiffness K0B and with it A.
%
% See also getss, mrltv.
  if nargin < 2, error('spacar:arguments', 'spacntrl needs a file and a function: spacntrl(''robotinvlin'', @kp)'); end
  source = result_file(file, {'ltv'});
  if ~isa(kpfun, 'function_handle'), kpfun = str2func(char(kpfun)); end
  kpfun(-1);
  count = getfrsbf(source, 'nnom');
  table = '';
  for step = 1:getfrsbf(source, 'tdef')
    gain = kpfun(step);
    if ~isequal(size(gain), [count, count]) || ~isreal(gain)
      error('spacar:gain', 'step %d: KP is %d x %d, %d x %d is needed', step, size(gain, 1), size(gain, 2), count, count);
    end
    line = sprintf(',%.17g', gain);
    table = sprintf('%s%s\n', table, line(2:end));
  end
  gains = [tempname(), '.csv'];
  removed = onCleanup(@() delete(gains));
  fid = fopen(gains, 'w');
  fwrite(fid, table);
  fclose(fid);
  output = regexprep(source, '\.ltv$', 'kp.ltv');
  call_spacar({'spacntrl', source, '--kp', gains, '--output', output, '--quiet'});
end
