function m = mechanism_tables(name)
% What a drawing of a .sbd result needs: tables of nodes and elements, and the coordinates x, a column a step.
  m.file = result_file(name, {'sbd'});
  m.lnp = getfrsbf(m.file, 'lnp'); m.ln = getfrsbf(m.file, 'ln'); m.it = getfrsbf(m.file, 'it');
  m.rxyz = getfrsbf(m.file, 'rxyz'); m.rq = getfrsbf(m.file, 'rq'); m.length = getfrsbf(m.file, 'rl0');
  m.t = getfrsbf(m.file, 't');
  m.x = getfrsbf(m.file, 'x');
  if numel(m.t) > 1, m.x = m.x.'; end
  m.planar = ~any(m.lnp(:, 3));
end
