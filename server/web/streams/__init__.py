"""Live streams: what a run does, read from its files and sent to any number of viewers."""
