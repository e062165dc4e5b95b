"""The certificates that a connection trusts are read where there is one to check, and then only."""

import ssl
from typing import Any

import pytest

from seamark.client import AsyncClient, Client


@pytest.mark.parametrize("client", [Client, AsyncClient])
@pytest.mark.parametrize(
    ("server", "read"),
    [
        ("http://water.example", False),
        ("HTTP://water.example:8000/below", False),
        ("https://water.example", True),
        ("https://http.example", True),
    ],
)
def test_certificates_are_read_for_a_server_with_tls_alone(
    client: type[Client] | type[AsyncClient],
    server: str,
    read: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    contexts, create = list[ssl.SSLContext](), ssl.create_default_context

    def noted(**options: Any) -> ssl.SSLContext:
        contexts.append(create(**options))
        return contexts[-1]

    monkeypatch.setattr(ssl, "create_default_context", noted)

    client(server)

    assert [context.get_ca_certs() != [] for context in contexts] == [True] * read
