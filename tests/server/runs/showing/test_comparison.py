"""Paired comparisons of ranked runs on their reference trials."""

import pytest

from seamark.server.database.tables import User
from seamark.server.runs.showing.comparison import comparisons
from tests.cast import Backend

LUCK = (0.0, 0.3, -0.2, 0.1)  # of each reference trial, the same for everybody


def _ranked(backend: Backend, who: str, level: float, **changes: object) -> int:
    """Return a ranked run whose reference trials score `level` on average."""
    noise = (0.01, -0.01, 0.01, -0.01)
    known = [level + luck + each * level for luck, each in zip(LUCK, noise, strict=True)]
    trials = [{"score": score, "part": "reference"} for score in known]
    trials += [{"score": level + part, "part": "fresh"} for part in (-0.1, 0.0, 0.1, 0.2)]
    claim = backend.running(who, kind="ranked", benchmark="visibility-v2", **changes)
    assert backend.finish(claim, metrics={"score": level, "trials": trials})
    return claim.run_id


@pytest.fixture
def mark(backend: Backend) -> int:
    """A baseline's run."""
    backend.sign_up("mark")
    with backend.database.writing() as session:
        session.get_one(User, backend.user_id("mark")).is_baseline = True
    return _ranked(backend, "mark", 3.0, controller="built-in")


def test_a_run_is_compared_with_the_previous_one_and_with_the_baselines(
    backend: Backend, mark: int
) -> None:
    earlier = _ranked(backend, "ann", 3.2, controller="built-in")
    other = _ranked(backend, "ben", 3.9, controller="built-in")
    run_id = _ranked(backend, "ann", 3.5, controller="built-in", config={"tracker": "klt"})

    with backend.database.reading() as session:
        own = comparisons(session, run_id, with_previous=True)
        strangers = comparisons(session, run_id, with_previous=False)
        first = comparisons(session, other, with_previous=True)

    assert [each.other_id for each in own] == [earlier, mark]
    assert own[1].difference == pytest.approx(0.5)
    assert own[1].low is not None
    assert own[1].high is not None
    assert 0.48 < own[1].low < 0.5 < own[1].high < 0.52
    assert strangers == own[1:]
    assert [each.other_id for each in first] == [mark]
