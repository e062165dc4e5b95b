"""The web application with the cast; each of them has a browser."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest
from flask import Flask, session
from flask.testing import FlaskClient
from flask_wtf.csrf import generate_csrf
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.web import authentication, identity_provider
from tests.cast import Backend
from tests.services import oidc
from tests.services.oidc import Provider

URL = "http://localhost"
WORDS = "correct horse battery"
# What keeps its white space, and what white space beside it does not show.
_KEPT = re.compile(r"(<(pre|textarea|script|template)\b[^>]*>)(.*?</\2>)", re.DOTALL)
_BLOCKS = (
    *("article", "button", "caption", "circle", "dd", "details", "div", "dl", "dt", "fieldset"),
    *("figure", "form", r"h\d", "input", "label", "legend", "li", "main", "nav", "ol", "option"),
    *("p", "section", "select", "summary", "table", "tbody", "td", "th", "thead", "title"),
    *("tr", "ul"),
)
_BLOCK = re.compile(rf" ?(</?(?:{'|'.join(_BLOCKS)})\b[^>]*>) ?")


def one_line(html: str) -> str:
    """Return a page without the breaks of lines that do not show."""
    *before, last = _KEPT.split(html)
    parts = zip(before[::4], before[1::4], before[3::4], strict=True)
    return "".join(_joined(loose + tag) + kept for loose, tag, kept in parts) + _joined(last)


def _joined(markup: str) -> str:
    return _BLOCK.sub(r"\1", re.sub(r"\s+", " ", markup))


class PageText(TestResponse):
    """A response whose page is read as it shows."""

    @property
    def text(self) -> str:
        """The page in one line; anything else as it was sent."""
        sent = self.get_data(as_text=True)
        return one_line(sent) if self.mimetype == "text/html" else sent


@dataclass
class Browser:
    """A browser that keeps its cookies and sends the CSRF token that the form of a page holds."""

    client: FlaskClient

    def get(self, path: str, **options: Any) -> TestResponse:
        return self.client.get(path, **options)

    def post(self, path: str, data: dict[str, Any] | None = None, **options: Any) -> TestResponse:
        form = {"csrf_token": self.csrf_token()} | (data or {})
        return self.client.post(path, data=form, **options)

    def csrf_token(self) -> str:
        """Return what a page would hold that this browser asks for now, without its rendering."""
        with (
            self.client.session_transaction() as cookie,
            self.client.application.test_request_context(),
        ):
            session.update(cookie)
            token = str(generate_csrf())
            cookie.update(session)
        return token


@dataclass
class Site(Backend):
    """The application on the database of the cast."""

    app: Flask
    _cookies: dict[str, dict[str, Any]] = field(default_factory=lambda: {"stranger": {}})

    def browser(self, name: str = "stranger") -> Browser:
        """Return a browser in which `name` is signed in; a stranger's is empty."""
        if name not in self._cookies:
            self.sign_in(name)
        client = self.app.test_client()
        client.response_wrapper = type("Page", (PageText, client.response_wrapper), {})
        with client.session_transaction() as cookie:
            cookie.update(self._cookies[name])
        return Browser(client)

    def sign_in(self, name: str) -> None:
        """Sign `name` in anew, in the browsers from now on."""
        with self.app.app_context():
            self._cookies[name] = authentication.cookie_of(self.user_id(name))


@pytest.fixture
def site(backend: Backend) -> Iterator[Site]:
    app = create_app(backend.settings)
    yield Site(**vars(backend), app=app)
    app.extensions["seamark"].close()


def with_settings(backend: Backend, provider: Provider, **changes: Any) -> Site:
    values = {"oidc_issuer": provider.issuer, "oidc_client_id": oidc.CLIENT, "url": URL}
    values |= {"oidc_client_secret": oidc.SECRET, "oidc_name": "Example ID"} | changes
    settings = backend.settings.model_copy(update=values)
    return Site(**vars(backend) | {"settings": settings}, app=create_app(settings))


@pytest.fixture
def provider() -> Iterator[Provider]:
    with oidc.provider(URL + identity_provider.CALLBACK) as started:
        yield started


@pytest.fixture
def federated(backend: Backend, provider: Provider) -> Iterator[Site]:
    """The site with an identity provider; ann has a password."""
    with backend.database.writing() as session:
        accounts.change_password(session, "ann", WORDS)
    made = with_settings(backend, provider)
    yield made
    made.app.extensions["seamark"].close()
