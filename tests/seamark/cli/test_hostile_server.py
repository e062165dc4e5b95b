"""What a server answers is printed on a terminal, and does not act on it."""

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from seamark.cli.main import cli

ESCAPES = "\x1b]0;title\x07\x1b]52;c;cm0gLXJm\x07\x1b[2J\x9b31m\r\u202e"
ACTING = frozenset("\x1b\x07\x9b\r\u202e")
RUN: dict[str, Any] = {
    "id": 1,
    "benchmark": f"currents-v1{ESCAPES}",
    "title": ESCAPES,
    "public": True,
    "state": "queued",
    "position": None,
    "progress": 0.5,
    "links": {"page": f"/runs/1{ESCAPES}", "self": "/api/v1/runs/1"},
    "result": None,
    "failure": None,
}
FAILURE = {
    "cause": ESCAPES,
    **dict.fromkeys(("title", "sentence", "remedy", "traceback", "log"), ESCAPES),
}
ENDED: dict[str, dict[str, Any]] = {
    "failed": RUN | {"state": "failed", "failure": FAILURE},
    "succeeded": RUN
    | {
        "state": "succeeded",
        "result": {"score": 1.0, "digest": ESCAPES},
        "not_ranked": ESCAPES,
        "metrics": {"levels": [{"level": ESCAPES}], "custom_score": ESCAPES},
    },
    "unknown": RUN | {"state": f"cancelled{ESCAPES}"},
    "refused": {"type": ESCAPES, "status": 422, "title": ESCAPES, "detail": ESCAPES},
}


COMPETITION: dict[str, Any] = {
    **dict.fromkeys(("name", "title", "question", "benchmark", "zone", "state"), ESCAPES),
    **dict.fromkeys(("own_team", "digest"), ESCAPES),
    "teams": ESCAPES,
    "document": {},
    "links": {"page": ESCAPES},
    "rounds": [
        {
            **dict.fromkeys(("number", "kind", "quota", "trials"), ESCAPES),
            **{"opens_at": 1e300, "closes_at": -1e300, "accepts": False, "decided_at": None},
        }
    ],
}
BOARD_ROW = {
    **dict.fromkeys(("place", "place_low", "place_high", "team", "method", "run"), ESCAPES),
    **dict.fromkeys(("score", "score_low", "score_high"), 1e300),
}
BOARD = {"round": ESCAPES, "hidden": True, "rows": [BOARD_ROW], "reference_entries": [BOARD_ROW]}
CHECK = {
    **{"ended": True, "asked": 1, "waiting": 0},
    "findings": [{"level": ESCAPES, "sentence": ESCAPES}],
}
TEAM = {"name": ESCAPES, "members": [{"name": ESCAPES}]}


class CompetitionHandler(BaseHTTPRequestHandler):
    """Answers whatever is asked about competitions with escape sequences."""

    def do_GET(self) -> None:
        known = {"board": BOARD, "check": CHECK, "join": TEAM}
        path = self.path.partition("?")[0]
        body = json.dumps(known.get(path.rpartition("/")[2], COMPETITION)).encode()
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self) -> None:
        self.do_GET()

    def log_message(self, *arguments: object) -> None:
        """Print nothing."""


@pytest.fixture(params=ENDED)
def server(request: pytest.FixtureRequest) -> Iterator[str]:
    """The address of a server that answers with escape sequences."""
    ended = ENDED[request.param]

    class Handler(BaseHTTPRequestHandler):
        def _answer(self, status: int, document: dict[str, Any]) -> None:
            body = json.dumps(document).encode()
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            self._answer(422, ended) if "status" in ended else self._answer(202, RUN)

        def do_GET(self) -> None:
            self._answer(200, ended | {"state": ended["state"].removesuffix(ESCAPES)})

        def log_message(self, *arguments: object) -> None:
            """Print nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as listening:
        threading.Thread(target=listening.serve_forever, args=(0.02,), daemon=True).start()
        yield f"http://127.0.0.1:{listening.server_address[1]}"
        listening.shutdown()


@pytest.mark.slow
def test_nothing_that_a_server_answers_acts_on_the_terminal(server: str) -> None:
    answer = CliRunner().invoke(
        cli, ["submit", "currents-v1", "--controller", "pi", "--server", server, "--wait"]
    )

    assert answer.output.strip()
    assert not ACTING & set(answer.output)
    assert not isinstance(answer.exception, (KeyError, TypeError, ValueError))


@pytest.mark.parametrize(
    "words",
    [
        ("show", "cup-v1", "--round", "1"),
        ("check", "cup-v1"),
        ("open", "cup-v1"),
        ("move", "cup-v1", "1", "--until", "2027-05-01T12:00", "--reason", "Rain."),
        ("create", "cup.toml"),
        ("join", "{server}/competitions/cup-v1/join/ABCDE-12345", "--agree"),
    ],
)
def test_nothing_of_a_competition_acts_on_the_terminal(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    CliRunner().invoke(cli, ["competition", "init", "cup.toml"])
    with ThreadingHTTPServer(("127.0.0.1", 0), CompetitionHandler) as listening:
        threading.Thread(target=listening.serve_forever, args=(0.02,), daemon=True).start()
        server = f"http://127.0.0.1:{listening.server_address[1]}"
        given = [word.format(server=server) for word in words]
        answer = CliRunner().invoke(cli, ["competition", *given, "--server", server])
        listening.shutdown()

    assert answer.exit_code == 0, answer.output
    assert answer.output.strip()
    assert not ACTING & set(answer.output)
