"""How many runs an owner may have at a time and per day, and how many of them are used up."""

import time
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Run, User
from seamark.server.runs.failure_reasons import UNCHARGED
from seamark.server.runs.states import LIVE, RunState
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

    live: int
    live_max: int
    day: int
    day_max: int


def used_by(session: Session, viewer: Viewer, settings: Settings) -> Quota:
    """Return what the viewer has used of the quotas."""
    live = (Run.owner == viewer.owner, Run.state.in_(LIVE))
    charged = (Run.state == RunState.SUCCEEDED) | Run.cause.not_in(UNCHARGED)
    # Naming the states lets an index find the last day among thousands of runs of one owner.
    ended = (Run.owner == viewer.owner, Run.state.in_((RunState.SUCCEEDED, RunState.FAILED)))
    recent = (*ended, Run.finished_at > time.time() - _DAY_S, charged)
    live_now = session.scalar(select(func.count()).select_from(Run).where(*live)) or 0
    day = live_now + (session.scalar(select(func.count()).select_from(Run).where(*recent)) or 0)
    day_max = settings.quota_day if viewer.user_id is not None else settings.guest_quota_day
    return Quota(live=live_now, live_max=settings.quota_live, day=day, day_max=day_max)


def enforce(session: Session, viewer: Viewer, settings: Settings) -> None:
    """Raise QuotaExceeded if the viewer may not submit another run now; baselines always may."""
    if viewer.user_id is not None and session.get_one(User, viewer.user_id).is_baseline:
        return
    used = used_by(session, viewer, settings)
    if used.live >= used.live_max:
        raise QuotaExceeded(
            f"You already have {used.live} runs waiting or running, which is the limit. "
            "Wait for one to finish, or cancel one.",
            retry_after_s=60,
        )
    if used.day >= used.day_max:
        raise QuotaExceeded(
            f"You have had {used.day} runs in the last 24 hours, which is the limit. "
            "Cancelled runs and failures of the service do not count.",
            retry_after_s=3600,
        )
