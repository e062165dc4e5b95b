"""Built-in controllers that enter a dock."""
