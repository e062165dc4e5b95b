"""Logs of missions at the API: opened, read like runs, never ranked, never run again."""

import gzip
import io
from typing import Any

import numpy as np
import pytest
from werkzeug.test import TestResponse

from seamark.server.database.tables import Best
from tests.server.api.conftest import Site
from tests.services import forked_commands

NAMES = ("t", "x", "y", "z", "roll", "pitch", "yaw")


def _poses(rows: int = 40) -> bytes:
    t = 0.05 * np.arange(rows)
    columns = [t, 0.2 + 0.1 * np.sin(t), 0.1 + 0.0 * t, 1.65 + 0.0 * t, *np.zeros((3, rows))]
    lines = [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(NAMES), *lines]).encode()


def _open(site: Site, content: bytes, name: str = "log.csv", **fields: Any) -> TestResponse:
    data = {"mapping": "settings = {settle_s = 0}", "log": (io.BytesIO(content), name), **fields}
    return site.call("owner", "POST", "/api/v1/logs", data=data)


@pytest.mark.slow
def test_a_log_becomes_a_private_run_with_metrics_and_rows_that_can_be_deleted(site: Site) -> None:
    log = gzip.compress(_poses())
    with forked_commands.started_anew():
        opened = _open(site, log, "mission.csv.gz", title="pool", notes="day 2")

    run = opened.get_json()
    path = opened.headers["Location"]
    assert opened.status_code == 201, run
    assert (run["kind"], run["state"], run["public"]) == ("log", "succeeded", False)
    assert (run["title"], run["notes"]) == ("pool", "day 2")
    assert run["metrics"]["levels"][0]["rmse_m"] is not None
    assert run["metrics"]["levels"][0]["lost_percent"] is None
    manifest = site.call("owner", "GET", f"{path}/manifest.json").get_json()
    assert manifest["kind"] == "measured log, not simulated"
    assert "mission" not in str(manifest["log"])  # the name of a file may name its author
    rows = site.call("owner", "GET", f"{path}/telemetry.csv").text.splitlines()
    assert sum(not line.startswith("#") for line in rows) == 41
    series = site.call("owner", "GET", f"{path}/series.json?columns=x,thrust_0").get_json()
    assert site.call("owner", "GET", f"{path}/camera.jpg?t=0.5").status_code == 200
    assert site.call("other", "GET", path).status_code == 404
    assert series["columns"] is not None
    assert site.call("owner", "DELETE", f"{path}/data").status_code == 200
    assert site.call("owner", "GET", f"{path}/telemetry.csv").status_code == 410


@pytest.mark.slow
def test_a_log_is_not_run_again_and_never_ranks_even_when_it_is_public(site: Site) -> None:
    mapping = "settings = {settle_s = 0, levels = [0.2]}"
    path = _open(site, _poses(), mapping=mapping).headers["Location"]

    again = site.call("owner", "POST", f"{path}/rerun")
    published = site.call("owner", "POST", f"{path}/publish")

    assert again.status_code == 422
    assert "cannot be run again" in again.get_json()["detail"]
    assert published.status_code == 200
    assert site.call("other", "GET", path).status_code == 200
    with site.database.reading() as session:
        assert session.query(Best).count() == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "name", "fields", "sentence"),
    [
        (b"t,x\n0,1\n", "log.xlsx", {}, "not .xlsx"),
        (b"t\n", "log.csv", {"mapping": "["}, "neither TOML nor JSON"),
        (b"t\n", "log.csv", {"benchmark": "visibility-v1"}, "not by 'visibility-v1'"),
    ],
)
def test_a_log_that_cannot_be_opened_is_refused_with_the_reason(
    site: Site, content: bytes, name: str, fields: dict[str, str], sentence: str
) -> None:
    refused = _open(site, content, name, **fields)

    assert refused.status_code == 422
    assert refused.get_json()["type"] == "/problems/log-refused"
    assert sentence in refused.get_json()["detail"]


@pytest.mark.slow
def test_a_log_without_a_pose_has_nothing_for_the_player(site: Site) -> None:
    names = ["t", *(f"corner_{i}" for i in range(8))]
    lines = [",".join(map(str, [0.05 * at, *range(8)])) for at in range(40)]

    refused = _open(site, "\n".join([",".join(names), *lines]).encode())

    assert refused.status_code == 422
    assert "The player needs the vehicle's pose" in refused.get_json()["detail"]
