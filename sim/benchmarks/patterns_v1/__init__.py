"""patterns-v1: pattern recognition on the sea bottom."""
