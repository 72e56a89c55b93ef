function lines = mechanism_lines(m, x)
% The elements at the coordinates x as one line, 3 x n, with NaN between the elements: straight between position nodes;
% beams and tubes as the cubic that has the directions of the orientation nodes at its ends.
  lines = zeros(3, 0);
  for n = find(m.ln(:, 1))'
    nodes = m.ln(n, m.ln(n, :) > 0);
    positions = nodes(m.lnp(nodes, 2) > 0 & m.lnp(nodes, 4) == 0);
    turning = nodes(m.lnp(nodes, 4) > 0 | m.lnp(nodes, 2) == 0);
    if ~m.planar, turning = turning(m.lnp(turning, 4) > 0); end  % not the warping of a node
    if numel(positions) < 2, continue, end
    p = position(m, x, positions(1)); q = position(m, x, positions(2));
    if any(m.it(n) == [1, 5, 15, 16, 18]) && numel(turning) >= 2
      frame = m.rq(n, 1:3);
      if ~any(frame), frame = m.rxyz(n, 1:3); end
      s = linspace(0, 1, 13);
      part = p * (1 - 3 * s .^ 2 + 2 * s .^ 3) + q * (3 * s .^ 2 - 2 * s .^ 3) ...
           + m.length(n) * turned(m, x, turning(1), m.rxyz(n, 1:3)') * (s - 2 * s .^ 2 + s .^ 3) ...
           + m.length(n) * turned(m, x, turning(2), frame') * (s .^ 3 - s .^ 2);
    else
      part = [p, q];
    end
    lines = [lines, part, nan(3, 1)];
  end
end

function p = position(m, x, node)
  p = zeros(3, 1);
  places = m.lnp(node, 1:3);
  p(places > 0) = x(places(places > 0));
end

function v = turned(m, x, node, v)
% A vector of the initial state, turned with an orientation node: angle, or Euler parameters (l0, l).
  if m.lnp(node, 4) == 0
    a = x(m.lnp(node, 1));
    v = [cos(a), -sin(a), 0; sin(a), cos(a), 0; 0, 0, 1] * v;
  else
    l = x(m.lnp(node, 1:4));
    v = v + 2 * cross(l(2:4), cross(l(2:4), v) + l(1) * v);
  end
end
