"""currents-v1: position controllers in changing currents."""
