"""valve-v1: turn a valve with an arm."""
