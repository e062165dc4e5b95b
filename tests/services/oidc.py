"""An OpenID Connect provider in a thread, by the server side of Authlib: codes, PKCE, tokens.

A test may change what it answers, as a broken or a hostile one would.
"""

import json
import os
import secrets
import threading
import time
from base64 import urlsafe_b64encode
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from urllib.parse import urlsplit

from authlib.integrations.flask_oauth2 import AuthorizationServer
from authlib.oauth2.rfc6749 import AuthorizationCodeMixin, ClientMixin
from authlib.oauth2.rfc6749.grants import AuthorizationCodeGrant
from authlib.oauth2.rfc7636 import CodeChallenge
from authlib.oidc.core import OpenIDCode
from flask import Flask, jsonify, request
from joserfc import jwt
from joserfc.jwk import KeySet, OctKey, RSAKey
from werkzeug.serving import make_server

CLIENT, SECRET = "seamark", "only-for-tests"
Claims = dict[str, Any]


@dataclass
class Person:
    """Somebody who is signed in at the provider."""

    subject: str
    name: str = ""

    def get_user_id(self) -> str:
        return self.subject


@dataclass
class Code(AuthorizationCodeMixin):
    """An authorisation code; it works once."""

    person: Person
    redirect_uri: str
    nonce: str
    code_challenge: str
    code_challenge_method: str

    def get_redirect_uri(self) -> str:
        return self.redirect_uri

    def get_scope(self) -> str:
        return "openid profile"

    def get_nonce(self) -> str:
        return self.nonce

    def get_auth_time(self) -> int | None:
        return None

    def get_acr(self) -> str | None:
        return None

    def get_amr(self) -> list[str] | None:
        return None


class Client(ClientMixin):
    """The service under test, as the provider knows it."""

    def __init__(self, provider: "Provider") -> None:
        self._provider = provider

    def get_client_id(self) -> str:
        return CLIENT

    def get_default_redirect_uri(self) -> str:
        return self._provider.redirect_uri

    def get_allowed_scope(self, scope: Collection[str] | str) -> str:
        return str(scope)

    def check_redirect_uri(self, redirect_uri: str) -> bool:
        return redirect_uri == self._provider.redirect_uri

    def check_client_secret(self, client_secret: str) -> bool:
        return client_secret == SECRET

    def check_endpoint_auth_method(self, method: str, endpoint: str) -> bool:
        return method == "client_secret_basic"

    def check_response_type(self, response_type: str) -> bool:
        return response_type == "code"

    def check_grant_type(self, grant_type: str) -> bool:
        return grant_type == "authorization_code"


@cache
def new_key(_name: str) -> RSAKey:
    """Return a key to sign with, another for each name."""
    return RSAKey.generate_key(2048, {"kid": "1"})


def _unchanged(claims: Claims) -> Claims:
    return claims


@dataclass
class Provider:
    """A provider at `issuer`. Whoever is `person` is signed in there and agrees to everything."""

    redirect_uri: str
    person: Person = field(default_factory=lambda: Person("1", "ann"))
    change: Callable[[Claims], Claims] = _unchanged  # of the claims of a token
    change_metadata: Callable[[Claims], Claims] = _unchanged
    signs: str = "RS256"  # or HS256 with the client's secret, or none
    issuer: str = ""
    codes: dict[str, Code] = field(default_factory=dict)
    key: RSAKey = field(default_factory=lambda: new_key("1"))
    asked: list[str] = field(default_factory=list)  # paths
    pause_s: float = 0.0  # before each answer

    def token(self, claims: Claims) -> str:
        """Return an ID token with these claims, changed as the test wants."""
        changed = self.change(claims)
        header = {"alg": self.signs} | ({"kid": "1"} if self.signs == "RS256" else {})
        if self.signs == "RS256":
            return jwt.encode(header, changed, self.key)
        if self.signs == "none":
            parts = (urlsafe_b64encode(json.dumps(part).encode()) for part in (header, changed))
            return ".".join(part.decode().rstrip("=") for part in (*parts, b""))
        secret = OctKey.import_key(SECRET * 4)
        return jwt.encode(header, changed, secret, algorithms=[self.signs])


def _grants(provider: Provider) -> tuple[type[AuthorizationCodeGrant], type[OpenIDCode]]:
    class Grant(AuthorizationCodeGrant):
        TOKEN_ENDPOINT_AUTH_METHODS = ("client_secret_basic",)

        def save_authorization_code(self, code: str, request: Any) -> None:
            data = request.payload.data
            values = {name: data.get(name) for name in ("redirect_uri", "nonce")}
            values |= {name: data.get(name) for name in ("code_challenge", "code_challenge_method")}
            provider.codes[code] = Code(person=request.user, **values)

        def query_authorization_code(self, code: str, client: ClientMixin) -> Code | None:
            return provider.codes.get(code)

        def delete_authorization_code(self, authorization_code: Code) -> None:
            known = provider.codes.items()
            provider.codes = {code: each for code, each in known if each is not authorization_code}

        def authenticate_user(self, authorization_code: Code) -> Person:
            return authorization_code.person

    class Tokens(OpenIDCode):
        def exists_nonce(self, nonce: str, request: Any) -> bool:
            return False

        def encode_id_token(self, token: Claims, request: Any) -> str:
            now, code = int(time.time()), request.authorization_code
            claims = {"iss": provider.issuer, "aud": CLIENT, "iat": now, "exp": now + 60}
            claims |= {"sub": code.person.subject, "nonce": code.nonce}
            return provider.token(claims | {"preferred_username": code.person.name})

    return Grant, Tokens


def _app(provider: Provider) -> Flask:
    app = Flask("provider")
    save: Any = lambda token, request: None  # noqa: E731
    authorization: Any = AuthorizationServer(
        app, query_client=lambda name: Client(provider) if name == CLIENT else None, save_token=save
    )
    grant, tokens = _grants(provider)
    authorization.register_grant(grant, [tokens(require_nonce=True), CodeChallenge(required=True)])

    @app.before_request
    def note() -> None:
        provider.asked.append(request.path)
        time.sleep(provider.pause_s)

    @app.get("/.well-known/openid-configuration")
    def metadata() -> Any:
        found: Claims = {"issuer": provider.issuer, "jwks_uri": f"{provider.issuer}/keys"}
        found["authorization_endpoint"] = f"{provider.issuer}/authorize"
        found["token_endpoint"] = f"{provider.issuer}/token"
        found["id_token_signing_alg_values_supported"] = ["RS256", "HS256", "none"]
        return jsonify(provider.change_metadata(found))

    @app.get("/keys")
    def keys() -> Any:
        return jsonify(KeySet([provider.key]).as_dict(private=False))

    @app.get("/authorize")
    def authorize() -> Any:
        grant = authorization.get_consent_grant(end_user=provider.person)
        return authorization.create_authorization_response(grant=grant, grant_user=provider.person)

    @app.post("/token")
    def token() -> Any:
        return authorization.create_token_response()

    return app


@contextmanager
def provider(redirect_uri: str) -> Iterator[Provider]:
    """Start a provider on a free port of the loopback interface, over HTTP."""
    os.environ["AUTHLIB_INSECURE_TRANSPORT"] = "1"  # the server side refuses plain HTTP otherwise
    made = Provider(redirect_uri, person=Person(secrets.token_hex(8), "Ann.Smith"))
    server = make_server("127.0.0.1", 0, _app(made), threaded=True)
    made.issuer = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=lambda: server.serve_forever(0.02), daemon=True)
    thread.start()
    yield made
    server.shutdown()
    thread.join()
    server.server_close()


def path_of(address: str) -> str:
    """Return the path and query of an address."""
    parts = urlsplit(address)
    return f"{parts.path}?{parts.query}"
