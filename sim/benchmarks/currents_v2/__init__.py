"""currents-v2: position controllers in water that nobody has seen before."""
