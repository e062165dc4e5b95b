"""A WSGI application behind the web server's protocol, in a thread of the test."""

import asyncio
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.client import HTTPResponse

from uvicorn.config import Config
from uvicorn.server import Server

from seamark.embedded.connections import State
from seamark.embedded.protocols import PING_S, WEB_SOCKETS, Protocol, WebSocketProtocol
from seamark.server.web.asgi import AsgiApplication, WsgiApplication
from seamark.server.web.received_body import PATIENCE_S

BODY_MAX = 1_000_000


@contextmanager
def serving(
    wsgi: WsgiApplication,
    protocol: type[Protocol] = Protocol,
    web_socket: type[WebSocketProtocol] = WebSocketProtocol,
    state: State | None = None,
    *,
    keep_alive_s: int = 5,
    patience_s: float = PATIENCE_S,
    ping_s: float = PING_S,
    forced: bool = True,
) -> Iterator[Callable[[bytes], socket.socket]]:
    """Yield a function that connects and sends the bytes of a request."""
    application = AsgiApplication(
        wsgi, lambda _content_type: BODY_MAX, lambda _environ, _sent: None
    )
    application.patience_s = patience_s
    config = Config(
        application,
        timeout_keep_alive=keep_alive_s,
        http=protocol,
        ws=web_socket,
        **(WEB_SOCKETS | {"ws_ping_interval": ping_s, "ws_ping_timeout": ping_s}),
        lifespan="off",
        timeout_graceful_shutdown=1,
        interface="asgi3",
        log_config=None,
    )
    server = Server(config)
    server.server_state = state or State()
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(100)
        address = listener.getsockname()
        thread = threading.Thread(target=lambda: asyncio.run(server.serve([listener])))
        thread.start()

        def connect(request: bytes) -> socket.socket:
            connection = socket.create_connection(address, timeout=60)
            connection.sendall(request)
            return connection

        try:
            yield connect
        finally:
            server.should_exit, server.force_exit = True, forced
            thread.join()


def answer_of(connection: socket.socket, method: str = "GET") -> tuple[HTTPResponse, bytes]:
    """Return the answer and its body."""
    with connection, HTTPResponse(connection, method=method) as answer:
        answer.begin()
        return answer, answer.read()
