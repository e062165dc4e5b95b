"""Sweeps: one or two settings or parameters through several values, a run for each combination.

All runs of a sweep have one seed, so that they run the same trials: their scores differ by what is
swept alone. Cells are numbered row by row, the last axis changes fastest.
"""

import itertools
import math
import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.programs import configurations
from seamark.programs.parameters import KEY, Parameter
from seamark.server.database.submission_tables import Sweep
from seamark.server.database.tables import Run
from seamark.server.runs.record.run_notes import clean_title
from seamark.server.runs.record.states import LIVE, RunKind
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.sweep_axes import AXES_MAX, RUNS_MAX, Axis, Value, shown
from seamark.server.runs.submission.validation import (
    Submission,
    SubmissionRejected,
    ValidSubmission,
)
from seamark.server.settings import Settings
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.seeds import SEED_MAX

_SCALARS = {"number", "integer", "boolean", "string"}


@dataclass(frozen=True, slots=True)
class Cell:
    """A combination of values and its run; None if the run has been deleted."""

    values: tuple[Value, ...]
    run: RunView | None


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepView:
    """A sweep with its cells; it belongs to someone as a run does, and is never public."""

    id: int
    user_id: int | None
    guest: str | None
    benchmark: str
    title: str
    axes: tuple[Axis, ...]
    created_at: float
    cells: tuple[Cell, ...]
    public: bool = False
    program_public: bool = False
    teacher_id: int | None = None  # nobody else sees it: its runs may be those of an assignment
    entry: None = None  # no sweep counts in a competition

    @property
    def runs(self) -> list[RunView]:
        """The runs that there are, in the order of the cells."""
        return [cell.run for cell in self.cells if cell.run is not None]

    @property
    def live(self) -> int:
        """Number of runs that are waiting or running."""
        return sum(1 for run in self.runs if run.state in LIVE)

    @property
    def best(self) -> Cell | None:
        """The cell with the highest score so far, the first one of equals."""
        scored = [cell for cell in self.cells if _score(cell) is not None]
        return max(scored, key=lambda cell: _score(cell) or 0.0, default=None)


def plan(sent: Submission, axes: Sequence[Axis], settings: Settings) -> list[ValidSubmission]:
    """Return the validated runs of a sweep, cell by cell.

    Raises
    ------
    ConfigurationInvalid, SubmissionRejected
        As `submission.validate`, of the first run that is not valid; or this is no sweep.
    """
    if sent.kind is not RunKind.PRACTICE:
        raise _refused("A sweep consists of practice runs. Submit its best point as a ranked run.")
    names = [axis.name for axis in axes]
    if not 1 <= len(axes) <= AXES_MAX or len(set(names)) < len(names):
        raise _refused("Sweep one setting or parameter, or two different ones.")
    count = math.prod(len(axis.values) for axis in axes)
    if count > RUNS_MAX:
        raise _refused(f"This sweep has {count} runs; the limit is {RUNS_MAX}. Give fewer values.")
    benchmark = validation.find_benchmark(sent.benchmark)
    own = _own_parameters(benchmark, sent)
    for name in names:
        _check_name(benchmark, own, name)
        if sent.assignment is not None and name not in sweepable(benchmark, own, fixed=True):
            raise _refused(f"This assignment fixes {name}. Sweep a setting that you may choose.")
    seed = secrets.randbelow(SEED_MAX + 1) if sent.seed is None else sent.seed
    points = (
        dict(zip(names, values, strict=True))
        for values in itertools.product(*(axis.values for axis in axes))
    )
    return [
        validation.validate(
            replace(
                sent,
                seed=seed,
                config=_with(sent.config, point, own),
                title=_title(sent.title, point),
            ),
            settings,
        )
        for point in points
    ]


def submit(
    session: Session,
    planned: Sequence[ValidSubmission],
    axes: Sequence[Axis],
    settings: Settings,
    *,
    title: str = "",
) -> int:
    """Insert a sweep with all of its runs, or nothing, and return its id.

    Raises as `submission.submit_all`.
    """
    sent = planned[0].submission
    sweep = Sweep(
        user_id=sent.viewer.user_id,
        guest=None if sent.viewer.user_id is not None else sent.viewer.guest,
        benchmark=sent.benchmark,
        title=clean_title(title),
        axes=[{"name": axis.name, "values": list(axis.values)} for axis in axes],
        created_at=time.time(),
    )
    session.add(sweep)
    session.flush()
    submission.submit_all(session, planned, settings, sweep_id=sweep.id)
    return sweep.id


def show(session: Session, sweep_id: int) -> SweepView | None:
    """Return a sweep, or None."""
    sweep = session.get(Sweep, sweep_id)
    if sweep is None:
        return None
    axes = tuple(Axis(each["name"], tuple(each["values"])) for each in sweep.axes)
    runs = {run.sweep_cell: run for run in views.of_sweep(session, sweep_id)}
    cells = itertools.product(*(axis.values for axis in axes))
    return SweepView(
        id=sweep.id,
        user_id=sweep.user_id,
        guest=sweep.guest,
        benchmark=sweep.benchmark,
        title=sweep.title,
        axes=axes,
        created_at=sweep.created_at,
        cells=tuple(Cell(values, runs.get(at)) for at, values in enumerate(cells)),
    )


def live_runs(session: Session, sweep_id: int) -> list[int]:
    """Return the runs of a sweep that have not ended, the last one first.

    In this order no worker starts a run of it while those before are being cancelled.
    """
    query = select(Run.id).where(Run.sweep_id == sweep_id, Run.state.in_(LIVE))
    return list(session.scalars(query.order_by(Run.sweep_cell.desc())))


def sweepable(
    benchmark: Benchmark, declared: Sequence[Parameter], *, fixed: bool = False
) -> dict[str, Mapping[str, Any]]:
    """Return name -> schema of what can be swept: parameters first, then single-valued settings.

    `fixed` leaves out the scenario, which an assignment fixes.
    """
    own = {one.name: one.entry() for one in declared}
    settings = {
        name: entry
        for name, entry in benchmark.schema()["properties"].items()
        if entry["type"] in _SCALARS
        and "x-names" not in entry
        and name not in own
        and not (fixed and entry["x-role"] != "solution")
    }
    return own | settings


def _score(cell: Cell) -> float | None:
    return None if cell.run is None else cell.run.score


def _refused(sentence: str) -> SubmissionRejected:
    return SubmissionRejected(sentence, field="sweep")


def _own_parameters(benchmark: Benchmark, sent: Submission) -> tuple[Parameter, ...]:
    program = sent.program
    if program is None:
        return ()
    return configurations.declared_in(benchmark, program.language, program.parameters)


def _check_name(benchmark: Benchmark, own: Sequence[Parameter], name: str) -> None:
    if name in sweepable(benchmark, own):
        return
    if name in benchmark.configuration.model_fields:
        raise _refused(f"{name} cannot be swept: it is not a single number or choice.")
    also = f"; the program declares {', '.join(one.name for one in own)}" if own else ""
    raise _refused(f"{name[:80]} is neither a setting of this benchmark nor a parameter{also}.")


def _with(
    config: Mapping[str, object], point: Mapping[str, Value], own: Sequence[Parameter]
) -> dict[str, object]:
    """Return the configuration of one cell."""
    names = {one.name for one in own}
    below = {name: value for name, value in point.items() if name in names}
    beside = {name: value for name, value in point.items() if name not in names}
    if not below:
        return {**config, **beside}
    given = config.get(KEY)
    chosen = dict(given) if isinstance(given, Mapping) else {}
    return {**config, **beside, KEY: chosen | below}


def _title(title: str, point: Mapping[str, Value]) -> str:
    """Return the title of the run of a cell."""
    text = ", ".join(f"{name} {shown(value)}" for name, value in point.items())
    return f"{title}: {text}" if title else text
