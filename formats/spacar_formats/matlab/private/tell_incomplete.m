function tell_incomplete(d)
% Warn when the run of a result did not come to its end.
  if d.state ~= 1 || d.steps < d.committed
    warning('spacar:incomplete', '%s is incomplete: stopped after step %d', d.file, d.steps);
  end
end
