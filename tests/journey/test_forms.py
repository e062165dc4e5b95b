"""From the form to the leaderboard without scripts, embedded and on PostgreSQL."""

import re
import time

import httpx
import pytest

from tests.journey.service import Service

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


class FormClient:
    """Submits forms as a browser without scripts would."""

    def __init__(self, client: httpx.Client) -> None:
        self.client = client

    def post(self, page: str, action: str, fields: dict[str, str], **files: object) -> str:
        """Submit the form of a page with its CSRF token; return the path that it leads to."""
        token = re.search(r'name="csrf_token" value="([^"]+)"', self.client.get(page).text)
        assert token is not None
        response = self.client.post(action, data={"csrf_token": token[1], **fields}, files=files)  # type: ignore[arg-type]
        response.raise_for_status()
        return str(response.url.path)

    def ended(self, path: str) -> dict[str, object]:
        """Return the run once it has ended."""
        deadline = time.monotonic() + RUN_S
        while True:
            run: dict[str, object] = self.client.get(f"/api/v1{path}").json()
            if run["state"] not in ("queued", "running") or time.monotonic() > deadline:
                return run
            time.sleep(0.25)


# To start a service on PostgreSQL takes four times as long as the journey; the server's own tests
# run on both databases.
@pytest.mark.parametrize("where", ["service", pytest.param("production", marks=pytest.mark.long)])
def test_an_upload_goes_from_the_form_to_the_leaderboard(
    request: pytest.FixtureRequest, where: str
) -> None:
    running: Service = request.getfixturevalue(where)
    with httpx.Client(base_url=running.url, follow_redirects=True, timeout=30.0) as client:
        ended, rows, page = _journey(FormClient(client))

    assert (ended["state"], ended["cause"]) == ("succeeded", None)
    assert [entry["controller"] for entry in rows] == ["mine.py"]
    assert "forms" in page


def _journey(forms: FormClient) -> tuple[dict[str, object], list[dict[str, object]], str]:
    """Sign up, upload, wait, publish; return the run, its rows and the page of the leaderboard."""
    forms.post("/sign-up", "/sign-up", {"name": "forms", "password": "correct horse battery"})

    run = forms.post(
        "/submit/currents-v1",
        "/submit/currents-v1",
        {"controller": "upload", "source": "file", "kind": "ranked", "kp": "1.0"},
        program=("mine.py", PROGRAM, "text/x-python"),
    )
    ended = forms.ended(run)
    forms.post(run, f"{run}/publish", {"method": "Steady hand"})

    board = forms.client.get("/api/v1/leaderboards/currents-v1").json()
    mine = [row for row in board["ranks"] if row["user"] == "forms"]
    return ended, mine, forms.client.get("/leaderboards/currents-v1").text
