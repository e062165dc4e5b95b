"""A forward-looking imaging sonar: its device, its echoes, and its images."""
