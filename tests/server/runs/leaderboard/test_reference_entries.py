"""Reference entries: shipped results until the service has its own, which must agree with them."""

from collections.abc import Sequence

import pytest

from seamark.server.runs.leaderboard import reference_entries
from seamark.server.runs.submission import baselines
from seamark.sim.benchmarks import reference_results
from seamark.sim.engine.seeds import REFERENCE
from seamark.sim.registry import benchmark
from tests.cast import Backend

V2 = benchmark("visibility-v2")
FIRST_NAME, FIRST = next(iter(V2.baselines.items()))


def _finish_first(backend: Backend, scores: Sequence[float]) -> int:
    """Finish the baseline `FIRST` with these scores of reference trials."""
    trials = [
        {"trial": at, "score": score, "part": REFERENCE, "level_held": 0.2}
        for at, score in enumerate(scores)
    ]
    metrics = {"score": 1.5, "score_low": 1.0, "score_high": 2.0, "trials": trials}
    claim = backend.claim_alone(V2.name, FIRST.built_in)
    assert backend.finish(claim, metrics=metrics)
    return claim.run_id


@pytest.fixture
def with_baselines(backend: Backend) -> Backend:
    with backend.database.writing() as session:
        assert baselines.ensure(session, backend.settings)
    return backend


def test_a_new_service_shows_the_shipped_results_best_first(backend: Backend) -> None:
    with backend.database.reading() as session:
        found = reference_entries.entries(session, V2)

    shipped = reference_results.of_benchmark(V2)
    assert [entry.score for entry in found] == sorted(
        (one.score for one in shipped.values()), reverse=True
    )
    assert {entry.run_id for entry in found} == {None}
    assert {entry.title for entry in found if entry.is_bound} == set(V2.reference_built_in.values())


def test_baselines_that_wait_are_counted_apart(with_baselines: Backend) -> None:
    with_baselines.queue("ann")

    with with_baselines.database.reading() as session:
        live = reference_entries.live_count(session)

    with with_baselines.database.writing() as session:
        assert baselines.ensure(session, with_baselines.settings) == []
    assert live >= len(V2.baselines)


@pytest.mark.slow
@pytest.mark.parametrize("change", [0.0, 1e-15])
def test_a_computed_result_replaces_the_shipped_one_and_is_held_against_it(
    with_baselines: Backend, change: float
) -> None:
    shipped = reference_results.of_benchmark(V2)[FIRST_NAME]
    scores = [score + change for score in shipped.scores]

    run_id = _finish_first(with_baselines, scores)

    with with_baselines.database.reading() as session:
        shown = {entry.title: entry for entry in reference_entries.entries(session, V2)}
        deviating = dict(reference_entries.deviations(session))
    assert (shown[FIRST.title].run_id, shown[FIRST.title].score) == (run_id, 1.5)
    assert len(shown) == len(V2.baselines)
    assert deviating.get(f"{V2.title}: {FIRST.title}") == (run_id if change else None)
