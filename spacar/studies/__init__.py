"""Studies: many runs of one model. `sweep` varies its numbers, `trade` its discretization and integration."""
