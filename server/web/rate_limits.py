"""Rate limits for signing in, signing up and submitting runs and checks."""

import hashlib
from http import HTTPStatus

from flask import Flask, Response, g, request
from flask_limiter import Limiter

from seamark.server.accounts.permissions import GUESTS, Viewer
from seamark.server.classes.classrooms import PUPILS_MAX
from seamark.server.messaging import broker
from seamark.server.settings import Settings
from seamark.server.web import class_access
from seamark.server.web.client_network import address
from seamark.server.web.services import services

# Verifying a password deliberately takes 0.15 s of CPU time, so attempts have to be limited.
CREDENTIAL_ATTEMPTS = "10 per minute; 100 per hour"
SIGN_INS = "60 per minute; 600 per hour"  # also successful ones: a class may share one address
# Wrong passwords for one account, from all addresses. Who is signed in stays signed in meanwhile.
GUESSES = "20 per hour; 100 per day"
# Wrong codes of classes: of one account, and from one address, which a school may share.
CODES, CODES_OF_ADDRESS = "20 per hour; 100 per day", "300 per hour"
EXPORTS = "10 per hour"  # of all data of an account
PROOFS = "60 per hour"  # archives and audit files of competitions, which take a while to make
SUBMISSIONS = "30 per minute; 300 per hour"
CHECKS = "20 per minute; 300 per hour"

_BROKER_TIMEOUT_S = 2.0  # of a count; then each process counts in its own memory
_RETRY_AFTER = "X-RateLimit-Retry-After"  # the limiter adds it to every response

limiter = Limiter(address, headers_enabled=True, in_memory_fallback_enabled=True)


def client() -> str:
    """Return the key under which requests are counted: the account or the network."""
    viewer: Viewer = g.viewer
    return viewer.owner or f"{GUESTS}{viewer.network}"


def account() -> str:
    """Return the key under which guesses of a password are counted: the account's name."""
    viewer: Viewer = g.viewer
    name = request.form.get("name", "").strip() if viewer.user_id is None else viewer.name
    return hashlib.sha256(name.casefold().encode()).hexdigest()


def sign_ups() -> str:
    """Return how many accounts may be created from one address, or with the link to one class.

    Students of a school share its address, and their class limits how many they are.
    """
    if class_access.invited_to() is not None:
        return f"{PUPILS_MAX} per day"
    return f"{services().settings.sign_ups_per_hour} per hour"


def signs_up() -> str:
    """Return under which key new accounts are counted: the class of the link, or the address."""
    room = class_access.invited_to()
    return address() if room is None else f"class:{room.id}"


def failed(response: Response) -> bool:
    """Return whether a sign-in failed; only failures count as password attempts."""
    return response.status_code >= HTTPStatus.BAD_REQUEST


def register(app: Flask, settings: Settings) -> None:
    """Store the counts in the broker, so that all web processes share them.

    While the broker is away, each process enforces the same limits with counts of its own.
    """
    url = broker.redis_url(settings)
    app.config["RATELIMIT_STORAGE_URI"] = url.replace("unix://", "redis+unix://", 1)
    app.config["RATELIMIT_STORAGE_OPTIONS"] = {
        "socket_timeout": _BROKER_TIMEOUT_S,
        "socket_connect_timeout": _BROKER_TIMEOUT_S,
    }
    app.config["RATELIMIT_HEADER_RETRY_AFTER"] = _RETRY_AFTER
    # Registered before the limiter's own function, so that it runs after it.
    app.after_request(_only_when_refused)
    limiter.init_app(app)


def _only_when_refused(response: Response) -> Response:
    """Send the limiter's Retry-After only with refusals; elsewhere the header is the API's."""
    retry_after = response.headers.pop(_RETRY_AFTER, None)
    if response.status_code == HTTPStatus.TOO_MANY_REQUESTS and retry_after is not None:
        response.headers.setdefault("Retry-After", retry_after)
    return response
