"""From the HTTP form to the leaderboard's row, on both kinds of database and broker."""

import re
import time

import httpx
import pytest

from tests.journey.conftest import Service

pytestmark = [pytest.mark.host, pytest.mark.slow]

RUN_S = 120.0
PROGRAM = b"""
class Controller:
    def __init__(self, config):
        self.kp = config["kp"]

    def step(self, observation):
        x, y, _ = observation.error
        return [self.kp * x, self.kp * y, 0.0, 0.0]
"""


class Stranger:
    """Fills in forms as a browser without scripts would."""

    def __init__(self, client: httpx.Client) -> None:
        self.client = client

    def post(self, page: str, action: str, fields: dict[str, str], **files: object) -> str:
        """Send the form of a page with its hidden token; return the page that answers."""
        token = re.search(r'name="csrf_token" value="([^"]+)"', self.client.get(page).text)
        assert token is not None
        answer = self.client.post(action, data={"csrf_token": token[1], **fields}, files=files)  # type: ignore[arg-type]
        answer.raise_for_status()
        return str(answer.url.path)

    def ended(self, path: str) -> dict[str, object]:
        """Return the run when it has ended."""
        give_up = time.monotonic() + RUN_S
        while True:
            run: dict[str, object] = self.client.get(f"/api/v1{path}").json()
            if run["state"] not in ("queued", "running") or time.monotonic() > give_up:
                return run
            time.sleep(0.25)


@pytest.mark.parametrize("where", ["service", "production"])
def test_an_upload_goes_from_the_form_to_the_leaderboard(
    request: pytest.FixtureRequest, where: str
) -> None:
    running: Service = request.getfixturevalue(where)
    with httpx.Client(base_url=running.url, follow_redirects=True, timeout=30.0) as client:
        ended, row, page = _journey(Stranger(client))

    assert (ended["state"], ended["cause"]) == ("succeeded", None)
    assert [entry["controller"] for entry in row] == ["mine.py"]
    assert "forms" in page


def _journey(stranger: Stranger) -> tuple[dict[str, object], list[dict[str, object]], str]:
    """Sign up, upload, wait, publish; return the run, the own rows and the page of ranks."""
    stranger.post("/sign-up", "/sign-up", {"name": "forms", "password": "correct horse battery"})

    run = stranger.post(
        "/submit/currents-v1",
        "/submit/currents-v1",
        {"controller": "upload", "source": "file", "kind": "ranked", "kp": "1.0"},
        program=("mine.py", PROGRAM, "text/x-python"),
    )
    ended = stranger.ended(run)
    stranger.post(run, f"{run}/publish", {})

    board = stranger.client.get("/api/v1/leaderboards/currents-v1").json()
    mine = [row for row in board["ranks"] if row["user"] == "forms"]
    return ended, mine, stranger.client.get("/leaderboards/currents-v1").text
