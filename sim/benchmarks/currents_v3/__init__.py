"""currents-v3: position controllers in unknown water that comes from all sides alike."""
