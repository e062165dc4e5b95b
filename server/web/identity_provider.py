"""Signing in by OpenID Connect: the authorisation code flow with PKCE, state and nonce, by Authlib.

State, nonce and verifier are kept in the signed cookie of the browser that started, for one sign-in
at a time, and taken out when it comes back. What the provider answers is used once and not stored.

Authlib and what it needs is loaded where an identity provider is set: it takes a tenth of the start
of a web process.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import structlog
from flask import Flask, current_app, session

from seamark.server.accounts.identities import SUBJECT_MAX, Identity
from seamark.server.settings import Settings
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

if TYPE_CHECKING:
    from authlib.integrations.flask_client import FlaskOAuth2App

CALLBACK = "/sign-in/callback"  # the redirect URI that the provider must know
TIMEOUT_S = 5.0  # of each of the three answers of the provider that a sign-in needs
AT_ONCE_MAX = 8  # sign-ins that wait for the provider, in one process; pages need threads too
PENDING_S = 600.0  # for choosing a name, or confirming a link
_NAME, _PENDING, _NEXT = "oidc", "identity", "identity_next"
_EXTENSION = "seamark.identity_provider"
_ASYMMETRIC = ("RS", "PS", "ES", "Ed")  # what signs with a key that only the provider has
_waiting = threading.BoundedSemaphore(AT_ONCE_MAX)
_log = structlog.get_logger()


class ProviderAway(Exception):
    """The identity provider does not answer, or not as one."""


class SignInRefused(Exception):
    """The provider has recognised nobody, or what came back does not belong to this sign-in."""


def register(app: Flask, settings: Settings) -> None:
    """Make the client of the identity provider, if one is set; it connects at the first sign-in."""
    if settings.oidc_issuer:
        from authlib.integrations.flask_client import OAuth  # noqa: PLC0415

        clients: Any = OAuth(app)
        app.extensions[_EXTENSION] = clients.register(
            _NAME,
            client_id=settings.oidc_client_id,
            client_secret=settings.oidc_client_secret,
            server_metadata_url=settings.oidc_issuer.rstrip("/")
            + "/.well-known/openid-configuration",
            client_kwargs={
                "scope": "openid profile",
                "code_challenge_method": "S256",
                "default_timeout": TIMEOUT_S,
            },
        )


def require_provider() -> None:
    """Answer as if there were nothing where no identity provider is set."""
    if not services().settings.oidc_issuer:
        raise Problem("not-found", "This service has no identity provider.")


def start(following: str) -> str:
    """Return the address at the provider to which the browser goes now.

    Parameters
    ----------
    following
        The path of this site to which it goes in the end.

    Raises
    ------
    ProviderAway
    """
    for key in [name for name in session if name.startswith(f"_state_{_NAME}_")]:
        session.pop(key)  # earlier attempts would fill the cookie
    with _talking() as client:
        made = client.create_authorization_url(services().settings.url + CALLBACK)
    client.save_authorize_data(redirect_uri=services().settings.url + CALLBACK, **made)
    session[_NEXT] = following
    return str(made["url"])


def finish() -> tuple[Identity, str]:
    """Return whom the provider has recognised, and the path to go to.

    Raises
    ------
    ProviderAway
    SignInRefused
    """
    from authlib.common.errors import AuthlibBaseError  # noqa: PLC0415
    from joserfc.errors import JoseError  # noqa: PLC0415

    settings = services().settings
    expected: dict[str, Any] = {
        "iss": {"essential": True, "value": settings.oidc_issuer},
        "aud": {"essential": True, "value": settings.oidc_client_id},
        "sub": {"essential": True},
        "exp": {"essential": True},
    }
    try:
        with _talking() as client:
            token = client.authorize_access_token(claims_options=expected)
    except (AuthlibBaseError, JoseError, ValueError) as error:
        _log.warning("identity_refused", why=type(error).__name__)
        raise SignInRefused from None
    claims: dict[str, Any] = token.get("userinfo") or {}  # none without an ID token
    subject = str(claims.get("sub", ""))
    if not 0 < len(subject) <= SUBJECT_MAX:
        raise SignInRefused
    names = (claims.get(name) for name in ("preferred_username", "name"))
    label = next((text for text in names if isinstance(text, str) and text), "")
    identity = Identity(issuer=settings.oidc_issuer, subject=subject, label=label[:200])
    return identity, str(session.pop(_NEXT, ""))


def keep(identity: Identity, following: str) -> None:
    """Keep an identity until somebody has chosen a name, or confirmed the link to an account."""
    kept = {"subject": identity.subject, "label": identity.label, "at": time.time()}
    session[_PENDING] = kept | {"issuer": identity.issuer, "next": following}


def kept() -> tuple[Identity, str] | None:
    """Return the identity that `keep` has kept, and the path to go to; None if it is too old."""
    pending = session.get(_PENDING)
    if not pending or not 0.0 <= time.time() - pending["at"] <= PENDING_S:
        return None
    if pending["issuer"] != services().settings.oidc_issuer:
        return None
    names = ("issuer", "subject", "label")
    return Identity(**{name: pending[name] for name in names}), pending["next"]


def forget() -> None:
    """Forget the identity that was kept."""
    session.pop(_PENDING, None)


@contextmanager
def _talking() -> Iterator["FlaskOAuth2App"]:
    """Give the client, whose provider has answered; not to more requests than may wait for it."""
    import requests  # noqa: PLC0415

    if not _waiting.acquire(blocking=False):
        raise ProviderAway
    try:
        client: FlaskOAuth2App = current_app.extensions[_EXTENSION]
        _check(client.load_server_metadata())
        yield client
    except (requests.RequestException, RuntimeError) as error:
        _log.warning("identity_provider_away", why=type(error).__name__)
        raise ProviderAway from None
    finally:
        _waiting.release()


def _check(metadata: dict[str, Any]) -> None:
    """Refuse what another provider says; accept no token without a signature of the provider."""
    if metadata.get("issuer") != services().settings.oidc_issuer:
        _log.error("identity_provider_is_another", issuer=str(metadata.get("issuer"))[:200])
        raise ProviderAway
    named = metadata.get("id_token_signing_alg_values_supported") or ["RS256"]
    safe = [each for each in named if str(each).startswith(_ASYMMETRIC)]
    metadata["id_token_signing_alg_values_supported"] = safe
