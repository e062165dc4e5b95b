"""One folder per benchmark version."""
