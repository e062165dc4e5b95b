"""Messages between the processes of a worker, and what binds these processes together."""
