"""Sweeps: their plan, their rows, their quota."""

from typing import Any

import pytest
from redis import Redis
from sqlalchemy import func, select

from seamark.server.database.submission_tables import Sweep
from seamark.server.database.tables import Run
from seamark.server.runs.ending import cancellation
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import views
from seamark.server.runs.submission import sweeps
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.sweep_axes import Axis, read_axis
from seamark.server.runs.submission.sweeps import SweepView
from seamark.server.runs.submission.validation import Submission, SubmissionRejected
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import PI_RUN, Backend

KP = Axis("kp", (0.2, 0.4, 0.6))
KI = Axis("ki", (0.0, 0.02))
PROGRAM = b"""
PARAMETERS = {"gain": {"default": 0.5, "range": [0, 2]}, "kp": 1.0}
class Controller:
    def __init__(self, config): ...
    def step(self, observation): ...
"""


def _start(backend: Backend, *axes: Axis, who: str = "ann", **changes: Any) -> int:
    sent = Submission(**(PI_RUN | {"viewer": backend.viewers[who]} | changes))
    planned = sweeps.plan(sent, axes, backend.settings)
    with backend.database.writing() as session:
        return sweeps.submit(session, planned, axes, backend.settings, title=sent.title)


def _show(backend: Backend, sweep_id: int) -> SweepView:
    with backend.database.reading() as session:
        view = sweeps.show(session, sweep_id)
    assert view is not None
    return view


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.1, 0.2,5", (0.1, 0.2, 5)),
        ("0.1:1:4", (0.1, 0.4, 0.7, 1)),
        ("3 : 1 : 3", (3, 2, 1)),
        ("esm, ic", ("esm", "ic")),
        ([True, False], (True, False)),
    ],
)
def test_values_are_a_list_or_a_range(text: Any, values: tuple[object, ...]) -> None:
    assert read_axis("x", text).values == values


@pytest.mark.parametrize(
    "text",
    [
        *("", "0.1", "0:1:1", "0:1:65", "0:1", "a:b:3", "0:1:2:3", "0:inf:3", "1,1", "1, 1.0"),
        *([0.5], [float("nan"), 1.0], ",".join(map(str, range(65)))),
    ],
)
def test_other_values_are_refused(text: Any) -> None:
    with pytest.raises(SubmissionRejected):
        read_axis("x", text)


def test_a_sweep_is_a_run_for_each_combination_with_one_seed(both: Backend) -> None:
    view = _show(both, _start(both, KP, KI, config={"reference_limit_m_s": 0.7}))

    points = [(cell.run.config["kp"], cell.run.config["ki"]) for cell in view.cells if cell.run]
    assert points == [cell.values for cell in view.cells]
    assert points == [(kp, ki) for kp in KP.values for ki in KI.values]
    assert len({run.seed for run in view.runs}) == 1
    assert {run.config["reference_limit_m_s"] for run in view.runs} == {0.7}
    assert [run.id for run in view.runs] == sorted(run.id for run in view.runs)
    assert view.runs[0].title == "kp 0.2, ki 0"


def test_parameters_of_the_program_are_swept_before_settings_of_their_name(
    backend: Backend,
) -> None:
    program = backend.store_program(PROGRAM)
    view = _show(
        backend,
        _start(backend, Axis("gain", (0.1, 0.2)), KP, controller="upload", program=program),
    )

    points = [tuple(run.config["parameters"].values()) for run in view.runs]
    assert points == [cell.values for cell in view.cells]
    assert len({run.config["kp"] for run in view.runs}) == 1


def test_all_or_none_of_the_runs_are_submitted(both: Backend) -> None:
    settings = both.settings.model_copy(update={"quota_day": 5})
    limited = Backend(both.database, settings, both.viewers)

    with pytest.raises(QuotaExceeded, match="This sweep has 6 runs, but only 5 of the 5"):
        _start(limited, KP, KI)

    with both.database.reading() as session:
        assert session.scalar(select(func.count()).select_from(Run)) == 0
        assert session.scalar(select(func.count()).select_from(Sweep)) == 0


def test_a_sweep_counts_as_one_live_run_and_as_all_of_a_day(backend: Backend) -> None:
    settings = backend.settings.model_copy(update={"quota_live": 2, "quota_day": 9})
    limited = Backend(backend.database, settings, backend.viewers)

    _start(limited, KP, KI)
    limited.queue("ann")

    with pytest.raises(QuotaExceeded, match="already have 2 runs"):
        limited.queue("ann")


def test_a_wrong_value_refuses_the_whole_sweep_with_its_sentence(backend: Backend) -> None:
    with pytest.raises(ConfigurationInvalid, match="kp"):
        _start(backend, Axis("kp", (0.2, 99.0)))


@pytest.mark.parametrize(
    ("axes", "part"),
    [
        ([Axis("levels", (0.1, 0.2))], "cannot be swept"),
        ([Axis("speed", (0.1, 0.2))], "neither a setting"),
        ([KP, KP], "two different ones"),
        ([KP, KI, Axis("pid_kp", (1.0, 2.0))], "two different ones"),
        ([], "one setting or parameter"),
        ([Axis("kp", tuple(i / 100 for i in range(40))), KI], "has 80 runs; the limit is 64"),
    ],
)
def test_what_is_no_sweep_is_refused(backend: Backend, axes: list[Axis], part: str) -> None:
    with pytest.raises(SubmissionRejected, match=part) as refused:
        _start(backend, *axes)

    assert refused.value.field == "sweep"


def test_a_ranked_sweep_is_refused(backend: Backend) -> None:
    with pytest.raises(SubmissionRejected, match="consists of practice runs"):
        _start(backend, KP, kind=RunKind.RANKED)


def test_the_best_point_is_the_highest_score_and_failed_runs_have_none(backend: Backend) -> None:
    sweep_id = _start(backend, KP)
    for score in (40.0, 60.0):
        backend.finish(backend.claim_next(), score=score)
    failure: dict[str, Any] = dict.fromkeys(("metrics", "manifest", "digest"))
    backend.finish(backend.claim_next(), **failure, state=RunState.FAILED, cause="user_error")

    view = _show(backend, sweep_id)

    assert view.best is not None
    assert view.best.values == (0.4,)
    assert view.live == 0


def test_cancelling_a_sweep_cancels_what_has_not_ended(both: Backend, redis_url: str) -> None:
    sweep_id = _start(both, KP)
    other = both.queue("ann")
    both.finish(both.claim_next())

    with Redis.from_url(redis_url) as redis:
        cancelled = cancellation.cancel_sweep(both.database, redis, sweep_id)

    states = [run.state for run in _show(both, sweep_id).runs]
    assert cancelled == 2
    assert states == [RunState.SUCCEEDED, RunState.CANCELLED, RunState.CANCELLED]
    assert both.show(other).state is RunState.QUEUED


def test_a_deleted_run_leaves_an_empty_cell(backend: Backend) -> None:
    sweep_id = _start(backend, KP)
    with backend.database.writing() as session:
        session.delete(session.get_one(Run, _show(backend, sweep_id).runs[1].id))

    assert [cell.run is None for cell in _show(backend, sweep_id).cells] == [False, True, False]


def test_the_runs_of_a_sweep_are_found_by_an_index(backend: Backend) -> None:
    sweep_id = _start(backend, KP)
    query = "EXPLAIN QUERY PLAN SELECT id FROM runs WHERE sweep_id = ? ORDER BY sweep_cell"
    with backend.database.reading() as session:
        plan = session.connection().exec_driver_sql(query, (sweep_id,)).all()
        found = views.of_sweep(session, sweep_id)

    assert "ix_runs_sweep" in str(plan)
    assert len(found) == 3
