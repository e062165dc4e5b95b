"""Built-in controllers that follow a route."""
