"""The run of a leader that a page replays."""

from collections.abc import Sequence

from flask import g
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action, can
from seamark.server.runs import views
from seamark.server.runs.files import RunFiles
from seamark.server.runs.leaderboard import Rank
from seamark.server.runs.views import RunView
from seamark.server.web.services import services


def leader(session: Session, ranks: Sequence[Rank]) -> RunView | None:
    """Return the run of the first of these ranks that can be replayed, marks last; else None."""
    for rank in sorted(ranks, key=lambda one: one.is_baseline):
        run = views.show(session, rank.run_id)
        if run is not None and can(g.viewer, Action.VIEW, run) and files(run).row_count():
            return run
    return None


def files(run: RunView) -> RunFiles:
    """Return the files of a run."""
    return RunFiles(services().settings.data, run.id)
