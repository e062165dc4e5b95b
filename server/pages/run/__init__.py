"""The page of a run, lists of runs, and runs of mission logs."""
