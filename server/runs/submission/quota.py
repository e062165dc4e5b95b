"""How many runs an owner may have at a time and per day, how much they may take on disk, and how
much of that is used up.

Ranked runs have a further limit in each benchmark: each of them draws other fresh trials, and the
best of many draws is a lucky one.
"""

import math
import time
from dataclasses import dataclass

from sqlalchemy import Select, and_, func, or_, select
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import UNCHARGED
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Run, User
from seamark.server.runs.data.run_size import size
from seamark.server.runs.record.states import LIVE, RunKind, RunState, ranked_ended
from seamark.server.settings import Settings

_DAY_S = 86_400.0


class QuotaExceeded(Exception):
    """The owner has used up a quota. The text is for the form; `retry_after_s` for the API."""

    def __init__(self, sentence: str, *, retry_after_s: int) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Quota:
    """What an owner has used and may use; without cancelled runs and platform failures."""

    live: int  # all runs of a sweep count as one here
    live_max: int
    day: int
    day_max: int
    bytes: int
    bytes_max: int


def used_by(session: Session, viewer: Viewer, settings: Settings) -> Quota:
    """Return what the viewer has used of the quotas."""
    live = (Run.owner == viewer.owner, Run.state.in_(LIVE))
    charged = (Run.state == RunState.SUCCEEDED) | Run.cause.not_in(UNCHARGED)
    # Naming the states lets an index find the last day among thousands of runs of one owner.
    ended = (Run.owner == viewer.owner, Run.state.in_((RunState.SUCCEEDED, RunState.FAILED)))
    recent = (*ended, Run.finished_at > time.time() - _DAY_S, charged)
    counts = (func.count(), func.count(Run.sweep_id), func.count(Run.sweep_id.distinct()))
    runs, in_sweeps, sweeps = session.execute(select(*counts).select_from(Run).where(*live)).one()
    day = runs + (session.scalar(select(func.count()).select_from(Run).where(*recent)) or 0)
    is_user = viewer.user_id is not None
    own_day = session.scalar(select(User.quota_day).where(User.id == viewer.user_id))
    return Quota(
        live=runs - in_sweeps + sweeps,
        live_max=settings.quota_live,
        day=day,
        day_max=_day_max(settings, own_day) if is_user else settings.guest_quota_day,
        bytes=int(session.scalar(bytes_of(viewer.owner)) or 0),  # PostgreSQL adds up to a decimal
        bytes_max=settings.quota_bytes if is_user else settings.guest_quota_bytes,
    )


def _day_max(settings: Settings, own: int | None) -> int:
    """Return how many runs a user may complete in 24 h: the user's own number, if there is one."""
    return settings.quota_day if own is None else own


def bytes_of(owner: str | None) -> Select[int]:
    """Return the query of how many bytes the runs of an owner take, or may take when they end."""
    with_data = (Run.owner == owner, Run.data_bytes > 0)  # as the index has it
    return select(func.sum(Run.data_bytes)).where(*with_data)


def enforce(
    session: Session, viewer: Viewer, settings: Settings, *, new_bytes: int, new_runs: int = 1
) -> None:
    """Raise QuotaExceeded if the viewer may not submit a run or a sweep; baselines always may.

    Parameters
    ----------
    new_bytes
        What all of it may record (`run_size.estimate`).
    new_runs
        Number of runs of the sweep.
    """
    if _is_baseline(session, viewer):
        return
    used = used_by(session, viewer, settings)
    if used.live >= used.live_max:
        raise QuotaExceeded(
            f"You already have {used.live} runs waiting or running, which is the limit. "
            "Wait for one to finish, or cancel one.",
            retry_after_s=60,
        )
    if new_runs > 1 and used.day < used.day_max < used.day + new_runs:
        raise QuotaExceeded(
            f"This sweep has {new_runs} runs, but only {used.day_max - used.day} of the "
            f"{used.day_max} runs of 24 hours are left. Choose fewer values.",
            retry_after_s=3600,
        )
    if used.day >= used.day_max:
        raise QuotaExceeded(
            f"You have had {used.day} runs in the last 24 hours, which is the limit. "
            "Cancelled runs and failures of the service do not count.",
            retry_after_s=3600,
        )
    if used.bytes + new_bytes > used.bytes_max:
        whose = "Your runs" if viewer.user_id is not None else "The runs of guests of your network"
        raise QuotaExceeded(
            f"{whose} take {size(used.bytes)} of {size(used.bytes_max)}, and this one may record "
            f"{size(new_bytes)}. Delete the data of runs that you no longer need, on their pages "
            "or by DELETE /api/v1/runs/<id>/data, or record less.",
            retry_after_s=3600,
        )


def ranked_times(session: Session, viewer: Viewer, benchmark: str) -> list[float]:
    """Return when a user submitted the ranked runs of the last day that count, oldest first."""
    live = and_(Run.kind == RunKind.RANKED, Run.state.in_(LIVE))
    query = (
        select(Run.queued_at)
        .where(Run.user_id == viewer.user_id, Run.benchmark == benchmark)
        .where(Run.queued_at > time.time() - _DAY_S, or_(live, ranked_ended()))
        .order_by(Run.queued_at)
    )
    return list(session.scalars(query))


def enforce_ranked(session: Session, viewer: Viewer, benchmark: str, settings: Settings) -> None:
    """Raise QuotaExceeded if a user may not submit another ranked run of a benchmark now.

    Baselines always may.
    """
    if _is_baseline(session, viewer):
        return
    times = ranked_times(session, viewer, benchmark)
    if len(times) >= settings.ranked_day:
        wait_s = times[-settings.ranked_day] + _DAY_S - time.time()
        raise QuotaExceeded(
            f"You have submitted {len(times)} ranked runs of {benchmark} in the last 24 hours, "
            f"which is the limit. The next one is possible in {_duration(wait_s)}; until then try "
            "your ideas in practice runs, which do not count. Neither do failures of the service "
            "nor runs that were cancelled before they started.",
            retry_after_s=max(1, math.ceil(wait_s)),
        )


def _is_baseline(session: Session, viewer: Viewer) -> bool:
    return viewer.user_id is not None and session.get_one(User, viewer.user_id).is_baseline


def _duration(seconds: float) -> str:
    minutes = max(1, math.ceil(seconds / 60.0))
    return f"{minutes} min" if minutes < 60 else f"{minutes / 60.0:.1f} h"
