function [stress, coordinates, elements, extrema] = stressbeam(file, elements, step, options, section)
% STRESSBEAM  Von Mises stress in beams, from the stress resultants of a .sbd result.
%
%   [stress, coordinates, elements, extrema] = stressbeam(file, elements, step, options, section)
%
% ELEMENTS: numbers of BEAM, BEAMW or PLBEAM elements. STEP: the stored step, from 1. OPTIONS.exterior: true for points of the
% outline of the section only; OPTIONS.warping: false leaves out what the bimoment of a BEAMW does; OPTIONS may be [].
% SECTION(k), for element k or one for all:
%   CrossSection  Dimensions [m]
%   'rect'        [width thickness], the width along y', the direction that the input file gives
%   'circ'        diameter
%   'recthol'     [width thickness inner_width inner_thickness]
%   'circhol'     [diameter inner_diameter]
%   'i'           [flange_width height web_thickness flange_thickness]
%
% stress{k}: points of the section x 11 places from p to q [MPa]. coordinates(k): xi (places, 0 to 1), y, z (points, along
% y', z' [m]). elements: the numbers. extrema: max, min [MPa], element, place (xi) of the largest; NaN without elements.
%
% Normal stress N/A - Mz y/Iz + My z/Iy; shear of the torque (circle T r/J, rectangle by Saint-Venant's series, hollow
% rectangle by Bredt) and of the shear forces (parabola with the peak 3/2 Q/A, circle 4/3 Q/A, thin walls 2 Q/A); von
% Mises sqrt(sigma^2 + 3 tau^2). Resultants: theory-spatial.md section 3.5, theory-planar.md section 3.1.
% BEAMW: the torque has a part with Saint-Venant's shear stress and a warping torque with its own (theory-warping.md
% section 5); the bimoment B adds B omega/Cw to the normal stress, in a rectangle 36 |B|/(w t)^2 at the corners.
% The same numbers as those of `spacar stress`.
%
% See also getfrsbf, spavisual.
  if nargin < 5, error('spacar:arguments', 'stressbeam needs a file, elements, a step, options and sections'); end
  file = result_file(file, {'sbd'});
  types = getfrsbf(file, 'it'); le = getfrsbf(file, 'le'); lengths = getfrsbf(file, 'rl0');
  sig = getfrsbf(file, 'sig', step); sig = [0; sig(:)];
  places = linspace(0, 1, 11);
  warping = ~(isstruct(options) && isfield(options, 'warping') && ~options.warping);
  exterior = isstruct(options) && isfield(options, 'exterior') && options.exterior;
  elements = elements(:)';
  if numel(section) == 1, section = repmat(section, 1, numel(elements)); end
  if numel(section) ~= numel(elements)
    error('spacar:section', '%d sections for %d elements', numel(section), numel(elements));
  end
  stress = cell(1, numel(elements));
  coordinates = struct('xi', {}, 'y', {}, 'z', {});
  extrema = struct('max', NaN, 'min', NaN, 'element', NaN, 'place', NaN);
  last = []; points = [];
  for k = 1:numel(elements)
    n = elements(k);
    if n < 1 || n > numel(types) || ~any(types(n) == [1, 5, 18])
      error('spacar:element', 'element %g is no beam of %s', n, file);
    end
    if isempty(last) || ~isequal(section(k), last)
      points = section_points(section(k), exterior); last = section(k);
    end
    if types(n) == 5
      r = planar_resultants(file, n, step, le(n, :), sig, lengths(n), places);
    else
      r = spatial_resultants(file, n, step, le(n, :), sig, lengths(n), places, types(n) == 18);
    end
    if types(n) == 18 && warping
      r = warped_resultants(r, file, n, step, le(n, :), sig, lengths(n), places);
    end
    p = points;
    normal = p.one * (r.N / p.A) - p.y * (r.Mz / p.Iz) + p.z * (r.My / p.Iy) + p.omega * r.B;
    tauy = p.ty * r.T + p.sy * r.Qy + p.wy * r.Tw;
    tauz = p.tz * r.T + p.sz * r.Qz + p.wz * r.Tw;
    mises = sqrt(normal .^ 2 + 3 * (tauy .^ 2 + tauz .^ 2)) / 1e6;
    stress{k} = mises;
    coordinates(k) = struct('xi', places, 'y', p.y, 'z', p.z);
    [most, where] = max(max(mises, [], 1));
    if ~(most <= extrema.max), extrema.max = most; extrema.element = n; extrema.place = places(where); end
    extrema.min = min(extrema.min, min(mises(:)));
  end
end

function r = spatial_resultants(file, n, step, rows, sig, l0, xi, warped)
% N, Qy, Qz [N], T with Saint-Venant's stresses, My, Mz [N m], bimoment B [N m^2] and warping torque Tw [N m] at xi.
  s = sig(rows(1:6) + 1);
  e = getfrsbf(file, 'e', step); e = [0; e(:)]; e = e(rows(1:6) + 1);
  stiffness = getfrsbf(file, 'stif'); measures = getfrsbf(file, 'kdef');
  measure = measures(n); torque = s(2); phi = [0 0];
  if warped, torque = torque + sig(rows(7) + 1) - sig(rows(8) + 1); else, phi = 12 * stiffness(n, 5:6) / l0 ^ 2; end
  second = any(measure == [1, 2]);
  if second, sz = 1 / (1 + phi(1)); sy = 1 / (1 + phi(2)); else, sz = double(measure == 0); sy = sz; end
  by_y = (s(3) + s(4)) * e(2) / (2 * l0) - second / l0 * (torque * (e(3) + e(4)) - 0.1 * s(1) * sy * (e(6) - e(5)));
  by_z = (s(5) + s(6)) * e(2) / (2 * l0) - second / l0 * (torque * (e(5) + e(6)) + 0.1 * s(1) * sz * (e(4) - e(3)));
  across = [s(5) - s(6) - sy * by_y; s(4) - s(3) - sz * by_z] * l0 / (l0 + e(1));
  forces = section_forces(s(1), across, e, l0, xi);
  y = l0 * s(3:4); z = l0 * s(5:6); flat = ones(size(xi));
  r = struct('N', forces(1, :), 'Qy', forces(2, :), 'Qz', forces(3, :), 'T', l0 * s(2) * flat, ...
             'My', y(1) + (y(2) - y(1)) * xi, 'Mz', z(1) + (z(2) - z(1)) * xi, 'B', 0 * xi, 'Tw', 0 * xi);
end

function forces = section_forces(along, across, e, l0, xi)
% N, Qy, Qz [N] at xi, of the forces along and across the chord: in the axes of both ends, linear between these (the module
% stresses of spacar_drawing has the formulas).
  tilt = [e(5) - e(6); e(4) - e(3)] / (2 * l0);
  force = (along - across' * tilt) * [sqrt(max(1 - tilt' * tilt, 0)); tilt] + [0; across];
  h = [e(2); e(3) + e(4); e(5) + e(6)] / (4 * l0);
  once = cross(h, force); twice = cross(h, once); part = 2 / (1 + h' * h);
  forces = (force + part * (twice + once)) * (1 - xi) + (force + part * (twice - once)) * xi;
end

function r = warped_resultants(r, file, n, step, rows, sig, l0, xi)
% Twist rate of the cubic twist angle less its mean, and the linear bimoment (theory-warping.md section 5).
  e = getfrsbf(file, 'e', step); e = [0; e(:)];
  e = e(rows(7:8) + 1); s = sig(rows(7:8) + 1);
  stiffness = getfrsbf(file, 'stif');
  uneven = (e(2) * (3 * xi .^ 2 - 2 * xi) - e(1) * (1 - 4 * xi + 3 * xi .^ 2)) / l0 ^ 2;
  whole = r.T + l0 * (s(1) - s(2));
  r.T = r.T + stiffness(n, 2) * uneven;
  r.Tw = whole - r.T;
  r.B = l0 ^ 2 * (s(1) + (s(2) - s(1)) * xi);
end

function r = planar_resultants(file, n, step, rows, sig, l0, xi)
% The moments at the ends are exact for the quadratic strains (theory-planar.md section 3.1, (3) to (5)). KDEF: 0, 1 sines
% without and with the quadratic terms; 2, 3 angles with and without them, whose cosine is left out.
  e = getfrsbf(file, 'e', step); e = [0; e(:)];
  s = sig(rows(1:3) + 1); e = e(rows(1:3) + 1);
  stiffness = getfrsbf(file, 'stif'); measures = getfrsbf(file, 'kdef');
  phi = 12 * stiffness(n, 3) / l0 ^ 2;
  scale = any(measures(n) == [1, 2]) / (60 * l0 * (1 + phi) ^ 2);
  a = (4 + 5 * phi + 2.5 * phi ^ 2) * scale; b = (2 + 10 * phi + 5 * phi ^ 2) * scale;
  cosine = [1; 1];
  if measures(n) < 2, cosine = sqrt(max(1 - (e(2:3) / l0) .^ 2, 0)); end
  p = -l0 * cosine(1) * (s(2) + (2 * a * e(2) + b * e(3)) * s(1));
  q = -l0 * cosine(2) * (s(3) + (2 * a * e(3) + b * e(2)) * s(1));
  forces = section_forces(s(1), [(p - q) / (l0 + e(1)); 0], [e(1); 0; 0; 0; -e(2:3)], l0, xi);
  zero = 0 * xi;
  r = struct('N', forces(1, :), 'Qy', forces(2, :), 'Qz', zero, 'T', zero, 'My', zero, 'Mz', p + (q - p) * xi, ...
             'B', zero, 'Tw', zero);
end
