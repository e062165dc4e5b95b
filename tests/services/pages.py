"""The application with a cast, in threads of the test, for browsers and clients."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread

from werkzeug.serving import make_server

from seamark.server.app import create_app
from tests.cast import Backend


@contextmanager
def served(backend: Backend, *, threaded: bool = False) -> Iterator[str]:
    """Give the address of a service without a worker."""
    app = create_app(backend.settings)
    server = make_server("127.0.0.1", 0, app, threaded=threaded)
    thread = Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    thread.join()
    server.server_close()
    app.extensions["seamark"].close()
