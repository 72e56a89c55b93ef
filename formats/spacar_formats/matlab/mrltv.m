function output = mrltv(file, modes, quasistatic, output)
% MRLTV  Modal reduction of the time-varying system of an .ltv result.
%
%   output = mrltv(file, modes)                          the modes of lowest frequency; the others answer statically
%   output = mrltv(file, modes, quasistatic)             only so many of the others; [] for all
%   output = mrltv(file, modes, quasistatic, output)     name of the reduced file; default FILEmr.ltv
%
% See also getss, spacntrl.
  if nargin < 2, error('spacar:arguments', 'mrltv needs a file and the number of modes'); end
  source = result_file(file, {'ltv'});
  words = {'mrltv', source, sprintf('%d', modes), '--quiet'};
  if nargin > 2 && ~isempty(quasistatic), words = [words, {'--quasi-static', sprintf('%d', quasistatic)}]; end
  if nargin < 4, output = regexprep(source, '\.ltv$', 'mr.ltv'); end
  call_spacar([words, {'--output', full_name(output)}]);
end
