"""`seamark bridge rosbridge --server`, whose server may say anything."""

import json
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

PATIENCE_S = 60.0
BUSY = "All places are taken."


@pytest.fixture
def busy_server() -> Iterator[str]:
    """The address of a server that has a place in nine minutes."""

    class Busy(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            body = json.dumps({"title": "T", "detail": BUSY}).encode()
            self.send_response(503)
            self.send_header("Retry-After", "540")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *arguments: object) -> None:
            """Print nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Busy) as listening:
        threading.Thread(target=listening.serve_forever, args=(0.02,), daemon=True).start()
        yield f"http://127.0.0.1:{listening.server_address[1]}"
        listening.shutdown()


@pytest.mark.slow
def test_ctrl_c_ends_the_wait_for_a_place(busy_server: str) -> None:
    command = ["bridge", "rosbridge", "currents-v1", "--port", "0", "--server", busy_server]
    bridge = subprocess.Popen(
        [sys.executable, "-m", "seamark.cli.main", *command, "--token", "smk_of_a_test"],
        stderr=subprocess.PIPE,
        text=True,
    )
    with bridge:
        assert bridge.stderr is not None
        waiting = re.search(r"ws://\S+\d", bridge.stderr.readline())
        assert waiting is not None
        with connect(waiting[0]) as program:
            assert bridge.stderr.readline() == f"{BUSY} Waiting ...\n"

            bridge.send_signal(signal.SIGINT)

            code = bridge.wait(PATIENCE_S)
            with pytest.raises(ConnectionClosed):
                program.recv(timeout=PATIENCE_S)
        said = bridge.stderr.read()

    assert code == 130
    assert said == "Stopped.\n"
