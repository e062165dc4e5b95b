"""What everybody may know of a user: ranks with their history, and published runs."""

from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import select, union
from sqlalchemy.orm import Session

from seamark.server.accounts import profiles
from seamark.server.accounts.permissions import Viewer
from seamark.server.accounts.profiles import Profile
from seamark.server.database.publication_tables import RankPoint
from seamark.server.database.tables import Best, User
from seamark.server.runs.leaderboard import leaderboard, rank_history, score_counts
from seamark.server.runs.leaderboard.board_rows import Rank
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import ListCursor, RunFilter, RunPage
from seamark.sim import registry


@dataclass(frozen=True, slots=True)
class Standing:
    """The rank of a user in a benchmark: now, if there is one, and earlier."""

    benchmark: str
    rank: Rank | None
    people: int  # on the leaderboard
    history: Sequence[RankPoint]  # oldest first


def of_user(session: Session, user_id: int) -> list[Standing]:
    """Return the ranks of a user in the benchmarks in which there is or was one."""
    ranked = select(Best.benchmark).where(
        Best.user_id == user_id, Best.benchmark.in_(registry.BENCHMARKS)
    )
    earlier = select(RankPoint.benchmark).where(RankPoint.user_id == user_id)
    known, rows = set(session.scalars(union(ranked, earlier))), []
    for name in filter(known.__contains__, registry.BENCHMARKS):
        history = rank_history.of_user(session, user_id, name)
        rank = leaderboard.rank_of(session, name, user_id)
        if rank is not None and rank.anonymous:
            continue  # a score of the history would tell which entry it is
        if rank is not None or history:
            rows.append(Standing(name, rank, score_counts.size(session, name), history))
    return rows


def published(
    session: Session, user: User, *, after: int | None = None, limit: int = 50
) -> RunPage:
    """Return public runs of a user, newest first."""
    run_filter = RunFilter(which="public", user=user.name)
    return run_lists.page(session, Viewer(), run_filter, start=ListCursor(after), limit=limit)


def is_known(session: Session, user: User) -> bool:
    """Return whether a user has shown anything: a run, or a word in the profile."""
    filled = profiles.of(user) != Profile()
    return filled or bool(published(session, user, limit=1).runs)
