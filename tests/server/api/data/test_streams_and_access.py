"""Streams over a real connection end with the access of whoever opened them."""

import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

import pytest

from seamark.server.accounts import accounts, browser_sessions
from seamark.server.web import authentication
from tests.server.api.conftest import Site
from tests.services.asgi import serving

DEADLINE_S = 60.0


@contextmanager
def _streams(site: Site, *headers: str) -> Iterator[list[socket.socket]]:
    """Yield a connection for each header, all of which have received the state of a run."""
    run_id = site.running("ann").run_id
    site.record(run_id, rows=1)
    opened = []
    with serving(site.app) as connecting:
        for header in headers:
            head = (
                f"GET /api/v1/runs/{run_id}/events HTTP/1.1\r\nHost: localhost\r\n{header}\r\n\r\n"
            )
            opened.append(connecting(head.encode()))
            opened[-1].settimeout(DEADLINE_S)
            _receive_until(opened[-1], b"event: telemetry")
        yield opened
        site.record(run_id, rows=1)
        for connection in opened[1:]:
            with closing(connection):
                _receive_until(connection, b"event: telemetry")


def _receive_until(connection: socket.socket, text: bytes) -> None:
    received = b""
    while text not in received:
        received += (piece := connection.recv(65536))
        assert piece, "the stream has ended"


def _ends(connection: socket.socket) -> None:
    """Receive the rest of a stream that ends and says so: a chunk of no bytes."""
    received = b""
    while not received.endswith(b"0\r\n\r\n"):
        received += (piece := connection.recv(65536))
        assert piece, "the connection broke"
    connection.close()


@pytest.mark.slow
@pytest.mark.parametrize("role", ["owner", "admin"])
def test_the_stream_of_a_revoked_token_ends_and_that_of_another_goes_on(
    site: Site, role: str
) -> None:
    def header(who: str) -> str:
        return f"Authorization: {site.headers[who]['Authorization']}"

    with _streams(site, header(role), header("reader")) as (revoked, _):
        token = site.headers[role]["Authorization"].removeprefix("Bearer ")
        with site.database.writing() as session:
            user_id = site.user_id({"owner": "ann", "admin": "root"}[role])
            found = {one.hash: one.id for one in accounts.tokens(session, user_id)}
            assert accounts.revoke_token(session, user_id, found[accounts.secret_hash(token)])
        _ends(revoked)


@pytest.mark.slow
def test_the_stream_of_a_browser_that_signs_out_ends_and_that_of_another_goes_on(
    site: Site,
) -> None:
    def cookie() -> str:
        browser = site.client()
        with site.app.app_context(), browser.session_transaction() as session:
            session.update(authentication.cookie_of(site.user_id("ann")))
        found = browser.get_cookie(site.app.config["SESSION_COOKIE_NAME"])
        assert found is not None
        return f"Cookie: {found.key}={found.value}"

    with _streams(site, cookie(), cookie()) as (signed_out, _):
        with site.database.writing() as session:
            _, first = browser_sessions.of_account(session, site.user_id("ann"), "")
            assert browser_sessions.end_by_handle(session, site.user_id("ann"), first.handle)
        _ends(signed_out)
