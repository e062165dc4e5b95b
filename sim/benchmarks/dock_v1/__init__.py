"""The benchmark dock-v1."""
