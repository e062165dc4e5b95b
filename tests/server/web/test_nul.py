"""The character NUL, which SQLite stores and PostgreSQL does not, is refused on both."""

from collections.abc import Iterator
from typing import Any

import pytest

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from tests.cast import PROGRAM, Backend
from tests.server.api.conftest import Site

FORM = {"controller": "pi", "kind": "practice"}
RUN = '{"benchmark": "currents-v1", "controller": "pi", "%s": "a\\u0000b"}'
REQUESTS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "sign-in": ("POST", "/sign-in", {"data": {"name": "a\0n", "password": "b"}}),
    "sign-up": ("POST", "/sign-up", {"data": {"name": "ann\0", "password": "long enough, this"}}),
    "a title": ("POST", "/submit/currents-v1", {"data": FORM | {"title": "a\0b"}}),
    "a number": ("POST", "/submit/currents-v1", {"data": FORM | {"kp": "0\0"}}),
    "a token's name": ("POST", "/tokens", {"data": {"name": "a\0", "scopes": "read"}}),
    "a token's name in JSON": (
        "POST",
        "/api/v1/tokens",
        {"json": {"name": "a\0", "scopes": ["read"]}},
    ),
    "a title in JSON": ("POST", "/api/v1/runs", {"data": RUN % "title"}),
    "notes in JSON": ("POST", "/api/v1/runs", {"data": RUN % "notes"}),
    "a query": ("GET", "/api/v1/runs?benchmark=a%00b", {}),
    "a query of a page": ("GET", "/runs/?of=all&user=a%00b", {}),
    "a path": ("GET", "/leaderboards/a%00b", {}),
    "a path of the API": ("GET", "/api/v1/leaderboards/a%00b", {}),
}


@pytest.fixture
def site(both: Backend) -> Iterator[Site]:
    app = create_app(both.settings)
    app.config.update(WTF_CSRF_METHODS=[])
    with both.database.writing() as session:
        text = accounts.new_token(session, both.user_id("root"), "t", ("read", "submit", "admin"))
    headers = {"root": {"Authorization": f"Bearer {text}"}, "nobody": {}}
    yield Site(both.database, both.settings, both.viewers, app, headers)
    app.extensions["seamark"].close()


@pytest.mark.parametrize("what", REQUESTS)
def test_a_text_with_nul_is_refused_on_both_databases(site: Site, what: str) -> None:
    method, path, options = REQUESTS[what]
    if isinstance(options.get("data"), str):
        options = options | {"content_type": "application/json"}

    for role in ("root", "nobody"):
        assert 400 <= site.call(role, method, path, **options).status_code < 500


def test_a_file_name_loses_its_nul(site: Site) -> None:
    head = b'--b\r\nContent-Disposition: form-data; name="program"; filename="mi\0ne.py"\r\n\r\n'
    run = (
        b'\r\n--b\r\nContent-Disposition: form-data; name="run"\r\n\r\n{"benchmark":"currents-v1"}'
    )
    body = head + PROGRAM + run + b"\r\n--b--\r\n"

    answer = site.call(
        "root", "POST", "/api/v1/runs", data=body, content_type="multipart/form-data; boundary=b"
    )

    assert answer.status_code < 500
