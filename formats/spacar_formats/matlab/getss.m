function [A, B, C, D] = getss(file, step)
% GETSS  State space system of one step of an .ltv result (modes 3, 4, 9).
%
%   sys = getss(file)                    step 1
%   sys = getss(file, step)
%   [A, B, C, D] = getss(file, step)     the matrices; D is zero where the file has none (no direct feedthrough)
%
% sys is ss(A, B, C, D) with the names of the signals where the control toolbox is there (Octave: pkg load control),
% otherwise a structure with the fields a, b, c, d, StateName, InputName, OutputName.
%
% FILE with or without extension. See also getfrsbf, mrltv, spacntrl.
  if nargin < 2, step = 1; end
  [d, fid, guard] = sbf_directory(result_file(file, {'ltv'}));
  tell_incomplete(d);
  matrices = cell(1, 3);
  names = 'ABC';
  full_form = ~sbf_find(d, 'ASP');
  for n = 1:3 * full_form
    k = sbf_find(d, names(n));
    if k == 0, error('spacar:id', 'ID not found: %s in %s; the result of mode 2 has no linearized system', names(n), d.file); end
    matrices{n} = sbf_value(fid, d, k, step);
  end
  if full_form
    [A, b, c] = matrices{:};
    feedthrough = zeros(size(c, 1), size(b, 2));
  else
    [A, b, c, feedthrough] = eliminated(fid, d, step);
  end
  k = sbf_find(d, 'D'); flag = sbf_find(d, 'DFT');
  if k > 0 && (flag == 0 || any(sbf_value(fid, d, flag, []))), feedthrough = sbf_value(fid, d, k, step); end
  if nargout > 1, B = b; C = c; D = feedthrough; return, end
  labels = {signal_names(fid, d, 'XNAMES', 'x', size(A, 1)), signal_names(fid, d, 'UNAMES', 'u', size(b, 2)), ...
            signal_names(fid, d, 'YNAMES', 'y', size(c, 1))};
  fields = {'StateName', 'InputName', 'OutputName'};
  if exist('ss', 'file') || exist('ss', 'class')
    A = ss(A, b, c, feedthrough);
    for n = 1:3
      try  %#ok<TRYNC> (a toolbox whose systems have no such names)
        A.(fields{n}) = labels{n};
      end
    end
  else
    A = struct('a', A, 'b', b, 'c', c, 'd', feedthrough);
    for n = 1:3, A.(fields{n}) = labels{n}; end
  end
end

function [A, B, C, D] = eliminated(fid, d, step)
% Of a large model ASP, BSP, CSP (row, column, value): dz = A11 z + A12 w + B1 u, 0 = A21 z + A22 w + B2 u, y = C1 z + C2 w.
  size_of = @(id) sbf_value(fid, d, sbf_find(d, id), []);
  nx = size_of('NX'); counts = {size_of('NU'), size_of('NY')};
  t = sbf_value(fid, d, sbf_find(d, 'ASP'), step);
  n = max(t(:, 1));
  S = sparse(t(:, 1), t(:, 2), t(:, 3), n, n);
  U = zeros(n, counts{1}); Y = zeros(counts{2}, n);
  k = sbf_find(d, 'BSP'); if k > 0, t = sbf_value(fid, d, k, step); U = full(sparse(t(:, 1), t(:, 2), t(:, 3), n, counts{1})); end
  k = sbf_find(d, 'CSP'); if k > 0, t = sbf_value(fid, d, k, step); Y = full(sparse(t(:, 1), t(:, 2), t(:, 3), counts{2}, n)); end
  z = 1:nx; w = nx + 1:n;
  X = -S(w, w) \ [full(S(w, z)), U(w, :)];
  AB = [full(S(z, z)), U(z, :)] + S(z, w) * X;
  CD = [Y(:, z), zeros(counts{2}, counts{1})] + Y(:, w) * X;
  A = AB(:, z); B = AB(:, nx + 1:end); C = CD(:, z); D = CD(:, nx + 1:end);
end

function names = signal_names(fid, d, id, letter, count)
% As the file has them, otherwise x1, x2, ...
  k = sbf_find(d, id);
  if k > 0 && d.rows(k) == count
    names = cellstr(sbf_value(fid, d, k, []));
  else
    names = cell(count, 1);
    for n = 1:count, names{n} = sprintf('%s%d', letter, n); end
  end
end
