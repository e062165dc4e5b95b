"""Programs of users: what they declare, how they are prepared, their limits, how they fail."""
