"""A set of runs is computed again: its pages, and what the owners see of it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import WIDTH
from tests.server.pages.conftest import Browser, Site

PAGES, API = "/admin/rejudgements", "/api/v1/admin/rejudgements"
CHOSEN = {"benchmark": "currents-v1", "reason": "The <drag> was wrong"}


def _start(root: Browser) -> str:
    answer = root.post(PAGES, data=CHOSEN)
    assert answer.status_code == 303
    return str(Path(answer.headers["Location"]).name)


def _json(client: Browser, path: str) -> Any:
    return client.get(path).json


def test_the_form_says_how_many_runs_match_and_what_they_take(site: Site) -> None:
    site.succeeded("ann")
    root = site.browser("root")

    shown = root.get(f"{PAGES}/new?benchmark=currents-v1").text
    none = root.get(f"{PAGES}/new?benchmark=currents-v1&kind=ranked").text
    wrong = root.get(f"{PAGES}/new?benchmark=currents-v1&from=yesterday").text

    assert "Compute 1 run again" in shown
    assert "Estimated machine time" in shown
    assert "No run matches." in none
    assert "“yesterday” is not a date" in wrong


@pytest.mark.slow
def test_results_that_differ_are_shown_accepted_and_explained_to_the_owner(site: Site) -> None:
    run_id = site.succeeded("ann")
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))
    root, ann = site.browser("root"), site.browser("ann")
    before = ann.get(f"/api/v1/runs/{run_id}")
    number = _start(root)
    computing = root.get(f"{PAGES}/{number}").text
    claim = site.claim_next()
    RunFiles(site.settings.data, claim.run_id, 1).append_rows(np.ones((5, WIDTH)))
    site.finish(claim, 51.0, digest="1" * 64)

    compared = root.get(f"{PAGES}/{number}").text
    table = root.get(f"{API}/{number}/differences.csv").text
    root.post(f"{PAGES}/{number}/accept")

    assert "Cancel and discard" in computing
    assert "50.00 → <strong>51.00</strong>" in compared
    assert f"\n{run_id},ann,practice,succeeded,succeeded,,,50.0,51.0," in table
    after = ann.get(f"/api/v1/runs/{run_id}", headers={"If-None-Match": before.headers["ETag"]})
    assert after.status_code == 200
    page = ann.get(f"/runs/{run_id}").text
    assert "The &lt;drag&gt; was wrong" in page
    assert "<dt>Earlier score</dt><dd>50.00</dd>" in page
    [kept] = _json(ann, f"/api/v1/runs/{run_id}/recomputations")["recomputations"]
    assert (kept["earlier"]["score"], kept["earlier"]["digest"]) == (50.0, "0" * 64)
    assert "detail" not in kept["earlier"]
    rows = ann.get(f"/api/v1/runs/{run_id}/telemetry.csv").text
    assert "at the time of the download, 5 rows" in rows  # of the computation that counts now


def test_nobody_sees_the_run_that_computes_another_one_again(site: Site) -> None:
    site.succeeded("ann")
    root = site.browser("root")
    _start(root)
    hidden = site.claim_next().run_id

    assert root.get(f"/runs/{hidden}").status_code == 404
    assert f'"/runs/{hidden}"' not in root.get("/admin/workers").text
    assert f'"/runs/{hidden}"' not in root.get("/runs/?of=all").text
