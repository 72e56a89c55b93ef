"""Runs of a study: settings, the record of a run, what is compared, ladders and their extrapolation, rows, workers."""
