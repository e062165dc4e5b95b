"""Files that users bring in place of a choice of a setting."""
