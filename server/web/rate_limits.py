"""How often one address may try passwords, make accounts and order runs."""

from http import HTTPStatus

from flask import Flask, Response, g, request
from flask_limiter import Limiter
from flask_limiter.util import get_remote_address

from seamark.server.accounts.permissions import Viewer
from seamark.server.messaging import broker
from seamark.server.settings import Settings
from seamark.server.web.services import services

# Checking a password takes 0.15 s of a core on purpose: guessing must be slow and cheap to bear.
SIGN_IN = "10 per minute; 100 per hour"
SIGN_INS = "60 per minute; 600 per hour"  # also those that succeed: a class behind one address
ORDER = "30 per minute"
CHECK = "20 per minute; 300 per hour"

_RETRY_AFTER = "X-RateLimit-Retry-After"  # what the limiter says; it would say it with each answer

limiter = Limiter(get_remote_address, headers_enabled=True, in_memory_fallback_enabled=True)


def who() -> str:
    """Return the key under which orders are counted: the account, the guest or the address."""
    viewer: Viewer = g.viewer
    return viewer.owner or request.remote_addr or "nobody"


def sign_ups() -> str:
    """Return how many accounts one address may make."""
    return f"{services().settings.sign_ups_per_hour} per hour"


def refused(answer: Response) -> bool:
    """Return whether a sign-in failed: only these count as tries of a password."""
    return answer.status_code >= HTTPStatus.BAD_REQUEST


def register(app: Flask, settings: Settings) -> None:
    """Count in the broker, so that all web processes share the counts."""
    url = broker.redis_url(settings)
    app.config["RATELIMIT_STORAGE_URI"] = url.replace("unix://", "redis+unix://", 1)
    app.config["RATELIMIT_IN_MEMORY_FALLBACK"] = [SIGN_IN]
    app.config["RATELIMIT_HEADER_RETRY_AFTER"] = _RETRY_AFTER
    app.after_request(_keep_to_refusals)  # before the limiter's own, so that it runs after it
    limiter.init_app(app)


def _keep_to_refusals(answer: Response) -> Response:
    """Let the limiter say when to come back only where it refused, and the API elsewhere."""
    told = answer.headers.pop(_RETRY_AFTER, None)
    if answer.status_code == HTTPStatus.TOO_MANY_REQUESTS and told is not None:
        answer.headers.setdefault("Retry-After", told)
    return answer
