"""Publishing a run."""
