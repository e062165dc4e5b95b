"""The ranks that people would have if some results of a benchmark were replaced.

Nothing is written: the leaderboard counts everybody as they are, and those whose best run would be
another are counted anew.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.database.tables import Best, Result, Run, User
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.leaderboard.board_rows import Cursor
from seamark.server.runs.record.states import RunKind, RunState


@dataclass(frozen=True, slots=True)
class RankChange:
    """The rank of a user before and after; None: not on the leaderboard."""

    before: int | None
    after: int | None


class RankPreview:
    """A leaderboard with some results replaced."""

    def __init__(
        self, session: Session, benchmark: str, replaced: Mapping[int, float | None]
    ) -> None:
        """Look at the people whose results would be replaced.

        Parameters
        ----------
        replaced
            Run -> its new score; None: it would not rank.
        """
        self._session, self._benchmark = session, benchmark
        users = set(_owners(session, replaced))
        self._before = dict(_standing(session, benchmark, users))
        self._after = dict(_best(session, benchmark, users, replaced))

    def of(self, user_id: int) -> RankChange | None:
        """Return the rank of a user before and after; None if it has nothing to do with these."""
        before, after = self._before.get(user_id), self._after.get(user_id)
        if before is None and after is None:
            return None
        return RankChange(
            None if before is None else self._count(before),
            None if after is None else self._count_after(after),
        )

    def _count(self, here: Cursor) -> int:
        return leaderboard.count_down_to(self._session, self._benchmark, here)

    def _count_after(self, here: Cursor) -> int:
        left = _down_to(here, self._before.values())
        return self._count(here) - left + _down_to(here, self._after.values())


def _down_to(here: Cursor, rows: Iterable[Cursor]) -> int:
    return sum(leaderboard.place(row) <= leaderboard.place(here) for row in rows)


def _owners(session: Session, runs: Collection[int]) -> Iterable[int]:
    ranked = (Run.id.in_(runs), Run.kind == RunKind.RANKED, Run.public)
    people = select(User.id).join(Run, Run.user_id == User.id).where(User.is_baseline.is_(False))
    return session.scalars(people.where(*ranked))


def _standing(
    session: Session, benchmark: str, users: Collection[int]
) -> Iterable[tuple[int, Cursor]]:
    """Yield where people are on the leaderboard."""
    here = (Best.benchmark == benchmark, Best.user_id.in_(users), Best.is_baseline.is_(False))
    for best in session.scalars(select(Best).where(*here)):
        yield best.user_id, Cursor(best.score, best.reached_at, best.run_id)


def _best(
    session: Session, benchmark: str, users: Collection[int], replaced: Mapping[int, float | None]
) -> Iterable[tuple[int, Cursor]]:
    """Yield where people would be: each with the best run, by its new score where it has one."""
    columns = (Run.id, Run.user_id, Run.finished_at, Result.score, Result.rankable)
    query = (
        select(*columns)
        .outerjoin(Result, Result.run_id == Run.id)
        .where(Run.benchmark == benchmark, Run.user_id.in_(users), Run.public)
        .where(Run.kind == RunKind.RANKED, Run.state.in_((RunState.SUCCEEDED, RunState.FAILED)))
    )
    best = dict[int, Cursor]()
    for row in session.execute(query):
        score = replaced.get(row.id, row.score if row.rankable else None)
        if score is None or row.user_id is None or row.finished_at is None:
            continue
        here = Cursor(score, row.finished_at, row.id)
        known = best.get(row.user_id)
        if known is None or leaderboard.place(here) < leaderboard.place(known):
            best[row.user_id] = here
    return best.items()
