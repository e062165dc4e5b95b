"""The embedded service: everything on this machine, started by one command."""
