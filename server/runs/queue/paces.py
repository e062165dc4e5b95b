"""How long evaluations take, from those that succeeded; recent ones count more.

A pace is wall time per simulated time, since the simulated time of a run is known beforehand. It
includes what the host does meanwhile: the other runs, and the trials that run in parallel.
"""

from sqlalchemy import case, select
from sqlalchemy.orm import Session

from seamark.server.database.queue_tables import Pace
from seamark.server.database.tables import Run
from seamark.server.database.upsert import upsert

_MEMORY = 10  # runs: each further one counts a tenth, so that the oldest fade


def record(session: Session, run_id: int, *, wall_s: float, simulated_s: float) -> None:
    """Take a run that succeeded into the mean of its benchmark, kind and language."""
    if wall_s <= 0.0 or simulated_s <= 0.0:  # the clock was changed
        return
    run = session.get_one(Run, run_id)
    pace = wall_s / simulated_s
    row = {"benchmark": run.benchmark, "kind": run.kind, "language": run.language or ""}
    weight = case((Pace.runs < _MEMORY, 1.0 / (Pace.runs + 1.0)), else_=1.0 / _MEMORY)
    mean = Pace.wall_per_simulated + weight * (pace - Pace.wall_per_simulated)
    change = {"wall_per_simulated": mean, "runs": Pace.runs + 1}
    upsert(session, Pace, row | {"wall_per_simulated": pace, "runs": 1}, change)


def expected_s(session: Session, run: Run, trial_s: float) -> float | None:
    """Return the wall time [s] that a run will probably take; None if nothing was measured yet.

    Parameters
    ----------
    trial_s
        Simulated duration of one trial of the run.
    """
    pace = _nearest(session, run)
    return None if pace is None else pace.wall_per_simulated * trial_s * run.trials


def _nearest(session: Session, run: Run) -> Pace | None:
    """Return the pace of the same benchmark whose runs are most like this one."""
    rows = session.scalars(select(Pace).where(Pace.benchmark == run.benchmark)).all()
    wanted = (run.kind, run.language or "")

    def likeness(pace: Pace) -> tuple[bool, bool, int]:
        return pace.language == wanted[1], pace.kind == wanted[0], pace.runs

    return max(rows, key=likeness, default=None)
