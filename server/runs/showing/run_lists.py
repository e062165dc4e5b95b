"""Lists of runs: whose they are, filtered, searched and sorted, in pages of bounded cost.

Newest and oldest first, a list goes through all runs. Any other order sorts a window of the newest
`SEEN_MAX` runs, then the window before it, and so on: no index has all orders of all filters.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal

from sqlalchemy import ColumnElement, Select, case, false, func, or_, select
from sqlalchemy.orm import Session
from sqlalchemy.sql.base import ReadOnlyColumnCollection

from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.database.tables import IS_LISTED, Result, Run, User
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView

LIMIT_MAX = 200
SEEN_MAX = 1000  # runs that a page of a list looks at
SEARCH_MAX, WORDS_MAX = 80, 8  # [character], [1] of a search
BUILT_IN, UPLOADED = "built-in", "uploaded"
Columns = ReadOnlyColumnCollection[str, ColumnElement[Any]]
# What filters and orders look at: a window of whole rows would cost several times as much.
_NEEDED = (
    *(Run.id, Run.state, Run.benchmark, Run.kind, Run.language, Run.title),
    *(Run.controller, Run.started_at, Run.finished_at, Run.anonymous),
    # Not to be guessed by a search.
    case((Run.anonymous, ""), else_=Run.program_name).label("program_name"),
)
PROGRAMS: Sequence[str] = (BUILT_IN, UPLOADED, *LANGUAGES)


class RunOrder(StrEnum):
    """In which order a list shows runs."""

    NEWEST = "newest"
    OLDEST = "oldest"
    HIGHEST = "highest"
    LOWEST = "lowest"
    TITLE = "title"
    PROGRAM = "program"
    LONGEST = "longest"

    @property
    def label(self) -> str:
        """The order in words."""
        return _LABELS[self]

    @property
    def by_id(self) -> bool:
        """Whether it is that of the numbers of the runs, which an index has."""
        return self in {RunOrder.NEWEST, RunOrder.OLDEST}


_LABELS = {
    RunOrder.NEWEST: "Newest first",
    RunOrder.OLDEST: "Oldest first",
    RunOrder.HIGHEST: "Highest score first",
    RunOrder.LOWEST: "Lowest score first",
    RunOrder.TITLE: "Title, A to Z",
    RunOrder.PROGRAM: "Program, A to Z",
    RunOrder.LONGEST: "Longest first",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFilter:
    """Which runs a list shows; a field that is left out does not filter."""

    which: Literal["mine", "public", "all"] = "mine"
    user: str | None = None
    states: Sequence[RunState] = ()
    benchmark: str | None = None
    kind: str | None = None
    program: str | None = None  # one of PROGRAMS
    text: str = ""  # words, each of which is in the title, the benchmark or the program

    @property
    def narrows(self) -> bool:
        """Whether it leaves out some of the runs that the list is about."""
        return bool(self.states or self.benchmark or self.kind or self.program or self.text.split())


@dataclass(frozen=True, slots=True)
class ListCursor:
    """Where a page begins: after the run `after`, or within the window before it after `skip`."""

    after: int | None = None
    skip: int = 0


FIRST = ListCursor()


@dataclass(frozen=True, slots=True)
class RunPage:
    """A page of a list; `next` is where the following page begins, None at the end."""

    runs: list[RunView]
    next: ListCursor | None


def page(
    session: Session,
    viewer: Viewer,
    run_filter: RunFilter,
    *,
    order: RunOrder = RunOrder.NEWEST,
    start: ListCursor = FIRST,
    limit: int = 50,
) -> RunPage:
    """Return runs: the viewer's own, the public ones, or (for an admin) all.

    A page looks at no more than `SEEN_MAX` of them: with a filter that few pass it may be short or
    empty and yet have a next one.
    """
    limit = max(1, min(limit, LIMIT_MAX))
    skip = 0 if order.by_id else max(0, min(start.skip, SEEN_MAX))
    all_seen = order.by_id and not run_filter.narrows
    window = _window(session, viewer, run_filter, order, start.after)
    window = window.limit(limit + 1 if all_seen else SEEN_MAX)
    seen = window.with_only_columns(*_NEEDED).subquery().c
    query = select(seen.id).where(*_conditions(seen, run_filter)).order_by(*_keys(seen, order))
    ids = list(session.scalars(query.limit(limit + 1).offset(skip)))
    following: ListCursor | None = None
    if len(ids) > limit and order.by_id:
        following = ListCursor(ids[limit - 1])
    elif len(ids) > limit:
        following = _within(session, seen, start, skip + limit)
    elif not all_seen:
        following = _window_after(session, seen, order)
    return RunPage(views.several(session, ids[:limit]), following)


def _window(
    session: Session, viewer: Viewer, run_filter: RunFilter, order: RunOrder, after: int | None
) -> Select[Run]:
    runs = _whose(session, viewer, run_filter)
    if order is RunOrder.OLDEST:
        return runs.where(Run.id > (after or 0)).order_by(Run.id)
    if after is not None:
        runs = runs.where(Run.id < after)
    return runs.order_by(Run.id.desc())


def _within(session: Session, seen: Columns, start: ListCursor, skip: int) -> ListCursor:
    """Return a place in the same window, which begins at the newest run unless `start` says more.

    Then runs that are submitted meanwhile do not move the pages.
    """
    after = start.after
    if after is None:
        after = session.scalars(select(func.max(seen.id))).one() + 1
    return ListCursor(after, skip)


def _window_after(session: Session, seen: Columns, order: RunOrder) -> ListCursor | None:
    edge = func.max(seen.id) if order is RunOrder.OLDEST else func.min(seen.id)
    last = session.scalar(select(edge).having(func.count() == SEEN_MAX))
    return None if last is None else ListCursor(last)


def _keys(run: Columns, order: RunOrder) -> tuple[ColumnElement[Any], ...]:
    if order is RunOrder.OLDEST:
        return (run.id.asc(),)
    # Not a join: PostgreSQL would read all results for it.
    score = select(Result.score).where(Result.run_id == run.id).scalar_subquery()
    keys: dict[RunOrder, tuple[ColumnElement[Any], ...]] = {
        RunOrder.HIGHEST: (score.desc().nulls_last(),),
        RunOrder.LOWEST: (score.asc().nulls_last(),),
        RunOrder.TITLE: ((run.title == "").asc(), func.lower(run.title).asc()),
        RunOrder.PROGRAM: (func.lower(func.coalesce(run.program_name, run.controller)).asc(),),
        RunOrder.LONGEST: ((run.finished_at - run.started_at).desc().nulls_last(),),
    }
    return (*keys.get(order, ()), run.id.desc())


def _conditions(run: Columns, run_filter: RunFilter) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = []
    if run_filter.states:
        conditions.append(run.state.in_(run_filter.states))
    if run_filter.benchmark is not None:
        conditions.append(run.benchmark == run_filter.benchmark)
    if run_filter.kind is not None:
        conditions.append(run.kind == run_filter.kind)
    if run_filter.program is not None:
        conditions.append(_is_program(run, run_filter.program))
    searched = (run.title, run.benchmark, run.program_name, run.controller)
    for word in run_filter.text[:SEARCH_MAX].split()[:WORDS_MAX]:
        conditions.append(_contains(run, searched, word))
    return conditions


def _is_program(run: Columns, program: str) -> ColumnElement[bool]:
    if program == BUILT_IN:
        return run.language.is_(None)
    return run.language.is_not(None) if program == UPLOADED else run.language == program


def _contains(
    run: Columns, columns: Sequence[ColumnElement[Any]], word: str
) -> ColumnElement[bool]:
    """Return whether a word is in one of the columns, or is the number of the run."""
    number = word.removeprefix("#")
    is_number = number.isascii() and number.isdecimal() and len(number) < len(str(2**53))
    named = run.id == int(number) if is_number else false()
    return or_(named, *(column.icontains(word, autoescape=True) for column in columns))


def _whose(session: Session, viewer: Viewer, run_filter: RunFilter) -> Select[Run]:
    """Select the runs that a list is about, by an index in the order of their ids."""
    query = select(Run).where(Run.deleted_at.is_(None), IS_LISTED)
    if run_filter.which == "public":
        query = query.where(Run.public)
    elif run_filter.which == "mine" or not can(viewer, Action.ADMINISTER):
        # Guests of one network have one owner, but each sees only the runs of their own cookie.
        own = Run.owner == (viewer.owner or "")
        query = query.where(own if viewer.guest is None else Run.guest == viewer.guest)
    elif run_filter.user is None and len(run_filter.states) == 1:
        query = query.where(Run.state == run_filter.states[0])
    if run_filter.user is not None:
        query = query.where(Run.owner == Viewer(user_id=_user_id(session, run_filter.user)).owner)
        if run_filter.which == "public":
            query = query.where(Run.anonymous.is_(False))
    return query


def _user_id(session: Session, name: str) -> int:
    return session.scalar(select(User.id).where(User.name_key == name.casefold())) or 0
