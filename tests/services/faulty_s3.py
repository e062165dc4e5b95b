"""A proxy in front of an S3 server that answers errors, hangs or refuses for a while."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Literal
from urllib.parse import urlsplit

Behaviour = Literal["works", "answers errors", "refuses keys", "hangs", "hangs in programs"]
HELD_BACK = frozenset({"connection", "transfer-encoding", "content-length", "date", "server"})


class FaultyS3:
    """What clients take for the S3 server; it works until it is told otherwise.

    Parameters
    ----------
    upstream
        Address of the server, such as http://127.0.0.1:5000.
    address
        Host and port at which this one listens; port 0: any free one.
    """

    def __init__(self, upstream: str, address: tuple[str, int] = ("127.0.0.1", 0)) -> None:
        self._behaviour: Behaviour = "works"
        self._changed = threading.Condition()
        self.asked = 0  # requests that came while it did not work
        faulty = self

        class Handler(_Handler):
            service, target = faulty, urlsplit(upstream).netloc

        self._server = _Server(address, Handler)
        host, port = self._server.server_address[:2]
        self.endpoint = f"http://{host!s}:{port}"
        threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True).start()

    def behave(self, behaviour: Behaviour) -> None:
        """Answer like this from now on; who hangs until then loses the connection."""
        with self._changed:
            self._behaviour = behaviour
            self._changed.notify_all()

    def admit(self, path: str) -> Behaviour:
        """Return what becomes of a request, after as long as it hangs."""
        with self._changed:
            found = self._behaviour
            self.asked += found != "works"
            if found == "hangs in programs":
                found = "hangs" if "/programs/" in path else "works"
            if found == "hangs":
                self._changed.wait_for(lambda: not self._behaviour.startswith("hangs"))
            return found

    def close(self) -> None:
        self.behave("works")
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print nothing of clients that were killed, or have given up."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    service: FaultyS3
    target: str
    protocol_version = "HTTP/1.1"

    def _pass_on(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", "0")))
        match self.service.admit(self.path):
            case "hangs":
                self.close_connection = True
            case "answers errors":
                self._answer(500, {}, b"<Error><Code>InternalError</Code></Error>")
            case "refuses keys":
                self._answer(403, {}, b"<Error><Code>InvalidAccessKeyId</Code></Error>")
            case "works":
                upstream = HTTPConnection(self.target, timeout=60.0)
                upstream.request(self.command, self.path, body, dict(self.headers.items()))
                answer = upstream.getresponse()
                self._answer(answer.status, dict(answer.getheaders()), answer.read())
                upstream.close()

    do_GET = do_PUT = do_POST = do_DELETE = do_HEAD = _pass_on  # noqa: N815 - of the library

    def _answer(self, status: int, headers: dict[str, str], body: bytes) -> None:
        self.send_response(status)
        length = headers.get("Content-Length", str(len(body)))
        for name, value in headers.items():
            if name.lower() not in HELD_BACK:
                self.send_header(name, value)
        self.send_header("Content-Length", length if self.command == "HEAD" else str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def log_message(self, *_: Any) -> None:
        """Print nothing."""


@contextmanager
def in_front_of(upstream: str, address: tuple[str, int] = ("127.0.0.1", 0)) -> Iterator[FaultyS3]:
    """Yield a proxy that works."""
    made = FaultyS3(upstream, address)
    try:
        yield made
    finally:
        made.close()
