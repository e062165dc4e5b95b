"""A trial: the control loop, the world of a level, and its replay."""
