"""Leaderboards of more rows than one answer has."""

import pytest

from seamark.server.database.tables import Best, Run, User
from tests.server.api.conftest import Site

PATH = "/api/v1/leaderboards/currents-v1"
PUPILS = 1010  # more than two of the pages that a CSV is read in


def _fill(site: Site) -> None:
    """Put a public ranked run of each of many pupils on the board."""
    with site.database.writing() as session:
        ids = range(1000, 1000 + PUPILS)
        for at in ids:
            session.add(User(id=at, name=f"pupil{at}", name_key=f"pupil{at}", created_at=1.0))
        session.flush()
        for at in ids:
            run = Run(id=at, owner=f"user:{at}", user_id=at, benchmark="currents-v1", public=True)
            run.kind, run.trials, run.config, run.controller = "ranked", 1, {}, "p"
            run.state, run.queued_at, run.finished_at = "succeeded", 1.0, 2.0
            session.add(run)
        session.flush()
        for at in ids:
            row = Best(benchmark="currents-v1", user_id=at, run_id=at, reached_at=2.0)
            row.score, row.score_low, row.score_high = at / 100, 0.0, 99.0
            session.add(row)


@pytest.mark.slow
def test_a_csv_has_all_ranks_unless_it_is_limited(site: Site) -> None:
    _fill(site)

    whole = site.call("guest", "GET", f"{PATH}?format=csv").text
    part = site.call("guest", "GET", f"{PATH}?format=csv&limit=7").text
    most = site.call("guest", "GET", f"{PATH}?format=csv&limit=500").text
    page = site.call("guest", "GET", PATH).get_json()

    assert (whole.count("pupil"), part.count("pupil"), len(page["ranks"])) == (PUPILS, 7, 50)
    assert page["next"]
    assert most.count("pupil") == 500
    assert whole.startswith(most)
    assert [line.split(",")[3] for line in whole.splitlines()[1:]] == [
        f"pupil{at}" for at in range(999 + PUPILS, 999, -1)
    ]
