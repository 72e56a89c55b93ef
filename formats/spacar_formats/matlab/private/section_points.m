function p = section_points(section, exterior)
% Points over a cross-section and what a unit of every resultant gives there: y, z [m]; A, Iy, Iz; ty, tz shear stress of
% a unit torque [1/m^3]; sy, sz of unit shear forces [1/m^2]; omega normal stress of a unit bimoment [1/m^4]; wy, wz shear
% stress of a unit warping torque [1/m^3] (theory-warping.md sections 2, 5); one: ones. Columns.
  d = section.Dimensions;
  shape = lower(section.CrossSection);
  needed = struct('rect', 2, 'circ', 1, 'recthol', 4, 'circhol', 2, 'i', 4);
  if ~isfield(needed, shape), error('spacar:section', 'there is no cross-section ''%s'': rect, circ, recthol, circhol, i', shape); end
  if numel(d) ~= needed.(shape) || any(~(d > 0))
    error('spacar:section', 'a section %s has %d positive dimensions', shape, needed.(shape));
  end
  if strncmp(shape, 'rect', 4)
    [y, z] = meshgrid(linspace(-0.5, 0.5, 15) * d(1), linspace(-0.5, 0.5, 15) * d(2));
    y = y(:); z = z(:);
    outline = abs(y) >= d(1) / 2 * (1 - eps) | abs(z) >= d(2) / 2 * (1 - eps);
    if strcmp(shape, 'recthol')
      inner = abs(y) < d(3) / 2 & abs(z) < d(4) / 2;
      y = y(~inner); z = z(~inner); outline = outline(~inner);
    end
  elseif strcmp(shape, 'i')
    [fy, fz] = meshgrid(linspace(-0.5, 0.5, 15) * d(1), d(2) / 2 - linspace(0, 1, 5) * d(4));
    steps = linspace(-0.5, 0.5, 15);
    [wy, wz] = meshgrid(linspace(-0.5, 0.5, 5) * d(3), steps(2:14) * (d(2) - 2 * d(4)));
    y = [fy(:); fy(:); wy(:)]; z = [fz(:); -fz(:); wz(:)];
    flange = abs(z) >= (d(2) / 2 - d(4)) * (1 - eps);
    outline = abs(z) >= d(2) / 2 * (1 - eps) | flange & abs(y) >= d(1) / 2 * (1 - eps) | ...
              flange & abs(z) <= (d(2) / 2 - d(4)) * (1 + eps) & abs(y) >= d(3) / 2 | ~flange & abs(y) >= d(3) / 2 * (1 - eps);
  else
    inside = 0;
    if strcmp(shape, 'circhol'), inside = d(2) / 2; end
    [r, a] = meshgrid(linspace(inside, d(1) / 2, 6), (0:23) * pi / 12);
    y = r(:) .* cos(a(:)); z = r(:) .* sin(a(:));
    outline = r(:) >= d(1) / 2 * (1 - eps);
  end
  if exterior, y = y(outline); z = z(outline); end
  none = zeros(size(y));
  p = struct('y', y, 'z', z, 'one', ones(size(y)), 'omega', none, 'wy', none, 'wz', none);
  switch shape
    case 'rect'
      p.A = d(1) * d(2); p.Iy = d(1) * d(2) ^ 3 / 12; p.Iz = d(2) * d(1) ^ 3 / 12;
      [p.ty, p.tz] = rectangle_twist(d(1), d(2), y, z);
      p.sy = 1.5 / p.A * (1 - (2 * y / d(1)) .^ 2);
      p.sz = 1.5 / p.A * (1 - (2 * z / d(2)) .^ 2);
      Cw = prod(d) ^ 3 / 144;
      if d(1) >= d(2)
        p.omega = -y .* z / Cw; p.wz = y .* (d(2) ^ 2 - 4 * z .^ 2) / (8 * Cw);
      else
        p.omega = y .* z / Cw; p.wy = -z .* (d(1) ^ 2 - 4 * y .^ 2) / (8 * Cw);
      end
    case 'i'
      web = d(2) - 2 * d(4); apart = d(2) - d(4);
      p.A = 2 * d(1) * d(4) + web * d(3);
      p.Iy = (d(1) * d(2) ^ 3 - (d(1) - d(3)) * web ^ 3) / 12;
      p.Iz = (2 * d(4) * d(1) ^ 3 + web * d(3) ^ 3) / 12;
      torsion = 2 * rectangle_torsion(d(1), d(4)) + rectangle_torsion(web, d(3));
      flange = abs(z) >= (d(2) / 2 - d(4)) * (1 - eps);
      p.ty = -2 * (z - sign(z) * apart / 2) / torsion .* flange;
      p.tz = 2 * y / torsion .* ~flange;
      p.sy = 1.5 / (2 * d(1) * d(4)) * (1 - (2 * y / d(1)) .^ 2) .* flange;
      p.sz = 1 / (apart * d(3)) * ~flange;
      p.omega = y .* sign(z) * apart / 2 .* flange / (d(4) * d(1) ^ 3 * apart ^ 2 / 24);
      p.wy = -sign(z) * 1.5 / (apart * d(1) * d(4)) .* (1 - (2 * y / d(1)) .^ 2) .* flange;
    case 'recthol'
      p.A = d(1) * d(2) - d(3) * d(4);
      p.Iy = (d(1) * d(2) ^ 3 - d(3) * d(4) ^ 3) / 12; p.Iz = (d(2) * d(1) ^ 3 - d(4) * d(3) ^ 3) / 12;
      tw = (d(1) - d(3)) / 2; th = (d(2) - d(4)) / 2;
      area = (d(1) - tw) * (d(2) - th);
      side = abs(y) >= d(3) / 2;
      p.ty = -sign(z) / (2 * area * th) .* ~side;
      p.tz = sign(y) / (2 * area * tw) .* side;
      p.sy = 2 / p.A * p.one; p.sz = p.sy;
    otherwise
      inner = 0;
      if strcmp(shape, 'circhol'), inner = d(2); end
      p.A = pi / 4 * (d(1) ^ 2 - inner ^ 2);
      p.Iy = pi / 64 * (d(1) ^ 4 - inner ^ 4); p.Iz = p.Iy;
      p.ty = -z / (2 * p.Iy); p.tz = y / (2 * p.Iy);
      if inner > 0
        p.sy = 2 / p.A * p.one;
      else
        p.sy = 4 / (3 * p.A) * (1 - (y .^ 2 + z .^ 2) / (d(1) / 2) ^ 2);
      end
      p.sz = p.sy;
  end
end

function [ty, tz] = rectangle_twist(w, h, y, z)
% Shear stresses of a unit torque in a rectangle, side w along y: Saint-Venant's series (Timoshenko and Goodier, Theory of
% Elasticity, art. 109), summed across the shorter side, where it converges fast.
  if w > h
    [tz, ty] = rectangle_twist(h, w, z, y);
    ty = -ty; tz = -tz;
    return
  end
  a = w / 2; b = h / 2;
  torsion = rectangle_torsion(w, h);
  n = 1:2:59;
  k = n * pi / (2 * a);
  terms = (-1) .^ ((n - 1) / 2) ./ n .^ 2;
  height = min(abs(z), b);
  decay = exp((height - b) * k);
  base = bsxfun(@plus, 1, exp(-2 * b * k));
  cosh_ = decay .* bsxfun(@rdivide, 1 + exp(-2 * height * k), base);  % cosh(kz)/cosh(kb) without overflow
  sinh_ = bsxfun(@times, sign(z), decay .* bsxfun(@rdivide, 1 - exp(-2 * height * k), base));
  factor = 16 * a / pi ^ 2;
  ty = -factor * ((cos(y * k) .* sinh_) * terms') / torsion;
  tz = (2 * y - factor * ((sin(y * k) .* cosh_) * terms')) / torsion;
end

function torsion = rectangle_torsion(w, h)
% Torsion constant [m^4], by the same series.
  a = min(w, h) / 2; b = max(w, h) / 2;
  n = 1:2:119;
  torsion = (2 * a) ^ 3 * 2 * b / 3 * (1 - 192 / pi ^ 5 * a / b * sum(tanh(n * pi * b / (2 * a)) ./ n .^ 5));
end
