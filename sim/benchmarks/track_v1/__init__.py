"""track-v1: follow a route by dead reckoning and sparse acoustic fixes, in a current."""
