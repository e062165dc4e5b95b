"""What everybody sees of published, verified and withdrawn runs is as wide as a phone."""

from collections.abc import Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.publication import publications
from seamark.server.runs.recomputation import verifications
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend
from tests.services.pages import served

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

PHONE_PX = 375
UNFOLD = "for (const part of document.querySelectorAll('details')) part.open = true"
WIDTH_OF_PAGE = "document.documentElement.scrollWidth"
TITLE = "Observer with a model of the thrusters, by all the members of a laboratory"


@pytest.fixture
def address(backend: Backend) -> Iterator[str]:
    """The address of a service with the cast and without a worker."""
    with served(backend, threaded=True) as found:
        yield found


def verified(backend: Backend, who: str, *, score: float) -> int:
    """Return a published ranked run of 50 points that has this score in fresh water."""
    program = backend.store_program()
    options = {"controller": "upload", "program": program, "title": TITLE}
    claim = backend.running(who, kind="ranked", **options)
    assert backend.finish(claim)
    RunFiles(backend.settings.data, claim.run_id, 1).append_rows(np.zeros((40, WIDTH)))
    run_id = backend.publish(claim.run_id, licence="LGPL-3.0-or-later")
    with backend.database.writing() as session:
        verifications.request(session, run_id, backend.settings)
    assert backend.finish(backend.claim_next(), score=score, digest="a" * 64)
    return run_id


def test_permanent_addresses_and_marked_rows_are_as_wide_as_a_phone(
    backend: Backend, address: str, chromium: Browser
) -> None:
    good, bad = verified(backend, "ann", score=50.0), verified(backend, "eva", score=10.0)
    gone = backend.published("ben")
    with backend.database.writing() as session:
        assert publications.withdraw(session, gone)
    shown = {
        f"/p/{good}": "verified",
        f"/p/{bad}": "not confirmed",
        f"/p/{gone}": "withdrawn",
        "/leaderboards/currents-v1": "not confirmed",
    }
    page = chromium.new_page(viewport={"width": PHONE_PX, "height": 800}, reduced_motion="reduce")

    widths = {}
    for path, word in shown.items():
        page.goto(address + path, wait_until="domcontentloaded")
        page.evaluate(UNFOLD)
        assert page.get_by_text(word).count() > 0, path
        widths[path] = page.evaluate(WIDTH_OF_PAGE)

    page.close()
    assert widths == dict.fromkeys(shown, PHONE_PX)
