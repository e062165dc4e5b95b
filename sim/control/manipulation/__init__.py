"""Controllers that move an arm: kinematics, where the work is seen, and what is done with it."""
