"""What passes through the broker: Celery tickets and live events."""
