"""How often one address may try passwords, make accounts and order runs."""

from flask import Flask
from flask_limiter import Limiter
from flask_limiter.util import get_remote_address

from server import broker
from server.settings import Settings

# Checking a password takes 0.15 s of a core on purpose: guessing must be slow and cheap to bear.
SIGN_IN = "10 per minute; 100 per hour"
SIGN_UP = "10 per hour"
ORDER = "30 per minute"

limiter = Limiter(get_remote_address, headers_enabled=True, in_memory_fallback_enabled=True)


def register(app: Flask, settings: Settings) -> None:
    """Count in the broker, so that all web processes share the counts."""
    url = broker.redis_url(settings)
    app.config["RATELIMIT_STORAGE_URI"] = url.replace("unix://", "redis+unix://", 1)
    app.config["RATELIMIT_IN_MEMORY_FALLBACK"] = [SIGN_IN]
    limiter.init_app(app)
