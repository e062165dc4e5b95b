"""The run of a leader that a page replays."""

from collections.abc import Iterable, Sequence
from itertools import islice

from flask import g
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.web.services import services

_SEEN_MAX = 10  # runs that are looked at; storage can be away, or their data deleted


def leaders(session: Session, ranks: Sequence[Rank]) -> list[RunView]:
    """Return the runs of the first of these ranks, marks last."""
    best_first = sorted(ranks, key=lambda one: one.is_baseline)
    return first(session, [rank.run_id for rank in best_first])


def first(session: Session, run_ids: Iterable[int]) -> list[RunView]:
    """Return the first of these runs."""
    return views.several(session, list(islice(run_ids, _SEEN_MAX)))


def first_replayable(runs: Iterable[RunView]) -> RunView | None:
    """Return the first of these runs that the viewer can replay; None if there is none.

    It looks at their files, so that it should not keep a transaction waiting.
    """
    for run in runs:
        if can(g.viewer, Action.VIEW, run) and files(run).row_count():
            return run
    return None


def files(run: RunView) -> RunFiles:
    """Return the files of a run."""
    return stored_files.of_run(services().settings, run)
