"""Many vehicles at once: the closed loop of each, all in one compiled call per control step."""
