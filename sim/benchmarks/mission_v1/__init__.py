"""mission-v1: search a seabed for the right box, recover it and bring it back."""
