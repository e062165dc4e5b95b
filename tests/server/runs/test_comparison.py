"""Paired comparisons of ranked runs on their reference trials."""

import pytest

from seamark.server.database.tables import User
from seamark.server.runs.comparison import compare, comparisons
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


def test_what_two_runs_have_in_common_cancels_out(backend: Backend, mark: int) -> None:
    run_id = _ranked(backend, "ann", 3.5, controller="built-in")

    with backend.database.reading() as session:
        found = compare(session, run_id, mark)
        back = compare(session, mark, run_id)

    assert found is not None
    assert back is not None
    assert (found.other_id, found.trials) == (mark, 4)
    assert found.difference == pytest.approx(0.5)
    assert found.low is not None
    assert found.high is not None
    assert 0.48 < found.low < 0.5 < found.high < 0.52
    assert back.difference == pytest.approx(-found.difference)


def test_only_runs_with_reference_trials_of_one_benchmark_can_be_compared(
    backend: Backend, mark: int
) -> None:
    others = [backend.succeeded("ann"), backend.succeeded("ann", kind="ranked"), 999]

    with backend.database.reading() as session:
        assert [compare(session, mark, other) for other in (*others, mark)] == [None] * 4


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
    assert strangers == own[1:]
    assert [each.other_id for each in first] == [mark]
