"""Competitions: an organiser makes a draft, has it checked, and opens it; then it is frozen."""

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from sqlalchemy import ColumnElement, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.competitions import keys
from seamark.competitions.document import (
    CompetitionDocument,
    DocumentInvalid,
    Final,
    RoundKind,
)
from seamark.competitions.document import Round as RoundPlan
from seamark.server.accounts.permissions import Role
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.competition_tables import (
    Competition,
    CompetitionFile,
    Round,
    RoundChange,
    Team,
    TeamMember,
)
from seamark.server.database.tables import User
from seamark.server.programs import own_files, vehicles
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.vehicles import StoredVehicle

COMPETITIONS_MAX = 100  # of one organiser
LISTED_MAX = 200
REASON_MAX = 300  # [character]
MOVES_MAX = 50  # changes of the times of a round
TIME_MAX_S = 3 * 366 * 86_400.0  # from now, of a time that is moved
CHECK = 0  # the number of the round in which the reference entries check a draft
FROZEN = "The competition is open, so what it asks can no longer change. Make a new version."


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """That the organiser moved the end of a round, or the beginning of a final."""

    at: float
    before: float
    after: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundView:
    """A round with what is known of it. Times are s since 1970; those of the plan may be older."""

    id: int
    competition_id: int
    number: int
    kind: RoundKind
    plan: RoundPlan | Final
    opens_at: float
    closes_at: float | None  # None: a final
    commitment: str
    key: str | None
    batches: int
    decided_at: float | None
    moves: tuple[Move, ...] = ()

    @property
    def has_opened(self) -> bool:
        """Whether its time has come."""
        return self.opens_at <= time.time()

    @property
    def has_closed(self) -> bool:
        """Whether nobody can submit to it any more."""
        return self.closes_at is not None and self.closes_at <= time.time()

    @property
    def accepts(self) -> bool:
        """Whether teams can submit to it now."""
        return self.closes_at is not None and self.has_opened and not self.has_closed

    @property
    def shows_board(self) -> bool:
        """Whether everybody sees its scores."""
        if self.kind is RoundKind.FINAL:
            return self.decided_at is not None
        hidden = isinstance(self.plan, RoundPlan) and self.plan.board == "hidden"
        return not hidden or self.decided_at is not None


@dataclass(frozen=True, slots=True, kw_only=True)
class CompetitionView:
    """A competition with its rounds; the check is not among them."""

    id: int
    name: str
    organiser_id: int | None
    organiser: str  # empty: the account was deleted
    document: CompetitionDocument
    digest: str
    has_picture: bool
    vehicle_sha256: str | None
    files: Mapping[str, str]  # setting -> SHA-256 of further files of the organiser's
    created_at: float
    opened_at: float | None
    ended_at: float | None
    teams: int
    rounds: tuple[RoundView, ...]

    @property
    def is_draft(self) -> bool:
        """Whether its organiser alone sees it."""
        return self.opened_at is None

    @property
    def current(self) -> RoundView | None:
        """The round that teams can submit to now."""
        return None if self.is_draft else next((one for one in self.rounds if one.accepts), None)

    @property
    def following(self) -> RoundView | None:
        """The next round whose time has not come."""
        return next((one for one in self.rounds if not one.has_opened), None)

    @property
    def final(self) -> RoundView | None:
        """The final, if there is one."""
        return self.rounds[-1] if self.rounds[-1].kind is RoundKind.FINAL else None

    @property
    def deciding(self) -> RoundView:
        """The round whose end decides the competition."""
        return self.rounds[-1]

    @property
    def qualification(self) -> RoundView:
        """The round that decides who is in the final."""
        return next(one for one in self.rounds if one.kind is RoundKind.QUALIFICATION)


def prepared(
    document: CompetitionDocument,
    vehicle: StoredVehicle | None,
    files: Sequence[StoredFile] = (),
) -> CompetitionDocument:
    """Return a document with its files, whose settings are valid and written as they are stored.

    Raises
    ------
    DocumentInvalid
        With a sentence for each setting that is wrong.
    VehicleRejected
        No such vehicle exists.
    FileRejected
        Another file cannot be used.
    """
    named = {file.setting: file.name for file in files}
    named |= {} if vehicle is None else {vehicles.FIELD: vehicle.name}
    for setting in named:
        if setting not in document.base.configuration.model_fields:
            what = setting.replace("_", " ")
            raise DocumentInvalid({setting: f"{document.benchmark} has no {what} to choose."})
    document = document.model_copy(update={"settings": document.settings | named})
    with own_files.lent(vehicle, files):
        values = document.scenario().model_dump(mode="json")
    settings = {name: values[name] for name in document.settings}
    return document.model_copy(update={"settings": settings})


def create(
    session: Session,
    organiser_id: int,
    document: CompetitionDocument,
    *,
    picture: bytes | None,
    vehicle: StoredVehicle | None,
    files: Sequence[StoredFile] = (),
    secret: bytes,
) -> int:
    """Make a draft of a prepared document and return its id.

    Parameters
    ----------
    picture
        PNG or JPEG.
    secret
        The service's seed key.

    Raises
    ------
    CompetitionRefused
        The name is taken, or the organiser has too many competitions.
    """
    own = select(func.count()).where(Competition.organiser_id == organiser_id)
    if (session.scalar(own) or 0) >= COMPETITIONS_MAX:
        raise CompetitionRefused(f"You have {COMPETITIONS_MAX} competitions: delete a draft first.")
    _require_free(session, document.name)
    made = Competition(
        name=document.name,
        organiser_id=organiser_id,
        document=document.canonical(),
        digest=document.digest(),
        picture=picture,
        vehicle_sha256=None if vehicle is None else vehicle.sha256,
        created_at=time.time(),
    )
    session.add(made)
    session.flush()
    _add_files(session, made.id, files)
    _add_rounds(session, made.id, document, secret)
    return made.id


def replace_draft(
    session: Session,
    view: CompetitionView,
    document: CompetitionDocument,
    *,
    picture: bytes | None,
    vehicle: StoredVehicle | None,
    files: Sequence[StoredFile] = (),
    secret: bytes,
) -> None:
    """Give a draft another prepared document; its check is to be made again.

    Without a picture it keeps the one it has.

    Raises
    ------
    CompetitionRefused
        It is open, or the new name is taken.
    """
    if not view.is_draft:
        raise CompetitionRefused(FROZEN)
    if document.name != view.name:
        _require_free(session, document.name)
    values: dict[str, object] = {
        "name": document.name,
        "document": document.canonical(),
        "digest": document.digest(),
        "vehicle_sha256": None if vehicle is None else vehicle.sha256,
    }
    if picture is not None:
        values["picture"] = picture
    session.execute(update(Competition).where(Competition.id == view.id).values(**values))
    for table in (Round, CompetitionFile):
        session.execute(delete(table).where(table.competition_id == view.id))
    _add_files(session, view.id, files)
    _add_rounds(session, view.id, document, secret)


def remove_draft(session: Session, view: CompetitionView) -> None:
    """Delete a draft; an open competition stays, and nobody else can have its name.

    Raises
    ------
    CompetitionRefused
        It is open.
    """
    if not view.is_draft:
        raise CompetitionRefused("An open competition cannot be deleted: teams rely on it.")
    session.execute(delete(Competition).where(Competition.id == view.id))


def open_up(session: Session, view: CompetitionView) -> None:
    """Show a draft that was checked to everybody, and freeze it.

    Raises
    ------
    CompetitionRefused
        It is open, or a round would be over before anybody saw it.
    """
    if not view.is_draft:
        raise CompetitionRefused("The competition is open.")
    late = next((one for one in view.rounds if one.has_closed), None)
    if late is not None:
        raise CompetitionRefused(
            f"Round {late.number} would already be closed. Choose later times and check again."
        )
    now = {"opened_at": time.time()}
    session.execute(update(Competition).where(Competition.id == view.id).values(**now))
    rounds = update(Round).where(Round.competition_id == view.id, Round.number == CHECK)
    session.execute(rounds.values(decided_at=now["opened_at"]))


def hand_over(session: Session, view: CompetitionView, user_id: int) -> None:
    """Give a competition to another organiser.

    Raises
    ------
    CompetitionRefused
        The account may not organise, or takes part in the competition.
    """
    user = session.get_one(User, user_id)
    if user.role not in {Role.ORGANISER.label, Role.ADMIN.label}:
        raise CompetitionRefused(
            f"{user.name} is no organiser. An admin can make the account one.", field="user"
        )
    if session.get(TeamMember, (view.id, user_id)) is not None:
        raise CompetitionRefused(
            f"{user.name} is in a team of this competition and has to leave it first.",
            field="user",
        )
    change = update(Competition).where(Competition.id == view.id)
    session.execute(change.values(organiser_id=user_id))


def move_round(
    session: Session, view: CompetitionView, number: int, until: float, reason: str
) -> None:
    """Move the end of a round, or the beginning of a final, for everybody to see.

    Rounds after it move by as much if they would begin before it ends.

    Raises
    ------
    CompetitionRefused
        The round is decided, the time has passed, it would be shorter, or there is no reason.
    """
    one = next((each for each in view.rounds if each.number == number), None)
    if one is None or view.is_draft:
        raise CompetitionRefused("Only rounds of an open competition are moved.")
    _require_movable(one, until, reason)
    reason = reason.strip()[:REASON_MAX]
    _move(session, one, until, reason)
    end = until
    for later in view.rounds[number:]:
        if later.opens_at >= end:
            break
        if later.closes_at is None:
            _move(session, later, end, reason)
            break
        length_s = later.closes_at - later.opens_at
        session.execute(update(Round).where(Round.id == later.id).values(opens_at=end))
        end += length_s
        _move(session, later, end, reason)


def _require_movable(one: RoundView, until: float, reason: str) -> None:
    if one.decided_at is not None or (one.kind is RoundKind.FINAL and one.batches):
        raise CompetitionRefused("This round is decided: it can no longer be moved.")
    if not reason.strip():
        raise CompetitionRefused("Give a reason: everybody sees it.", field="reason")
    before = one.opens_at if one.closes_at is None else one.closes_at
    if not max(before, time.time()) < until < time.time() + TIME_MAX_S:
        raise CompetitionRefused(
            "The new time must be later than the announced one, and in the future.", field="until"
        )
    if len(one.moves) >= MOVES_MAX:
        raise CompetitionRefused(f"A round is moved at most {MOVES_MAX} times.")


def find(session: Session, name: str) -> CompetitionView | None:
    """Return a competition; None if it does not exist."""
    return next(iter(_views(session, Competition.name == name, moves=True)), None)


def get(session: Session, competition_id: int) -> CompetitionView:
    """Return a competition that exists."""
    return _views(session, Competition.id == competition_id, moves=True)[0]


def listed(session: Session) -> list[CompetitionView]:
    """Return the competitions that everybody sees, the newest first."""
    return _views(session, Competition.opened_at.is_not(None))


def drafts_of(session: Session, organiser_id: int) -> list[CompetitionView]:
    """Return the drafts of an organiser."""
    own = Competition.organiser_id == organiser_id
    return _views(session, Competition.opened_at.is_(None) & own)


def picture(session: Session, competition_id: int) -> bytes | None:
    """Return the picture of a competition, PNG or JPEG, if it has one."""
    return session.scalar(select(Competition.picture).where(Competition.id == competition_id))


def _move(session: Session, one: RoundView, until: float, reason: str) -> None:
    column = "opens_at" if one.closes_at is None else "closes_at"
    session.execute(update(Round).where(Round.id == one.id).values({column: until}))
    before = one.opens_at if one.closes_at is None else one.closes_at
    session.add(
        RoundChange(round_id=one.id, at=time.time(), before=before, after=until, reason=reason)
    )


def _require_free(session: Session, name: str) -> None:
    acquire(session, AdvisoryLock.COMPETITIONS)
    if session.scalar(select(Competition.id).where(Competition.name == name)) is not None:
        raise CompetitionRefused(
            f"There is a competition {name}. Choose another name or the next version.", field="name"
        )


def _add_files(session: Session, competition_id: int, files: Sequence[StoredFile]) -> None:
    for file in files:
        named = {"setting": file.setting, "sha256": file.sha256}
        session.add(CompetitionFile(competition_id=competition_id, **named))
    session.flush()


def _add_rounds(
    session: Session, competition_id: int, document: CompetitionDocument, secret: bytes
) -> None:
    first = document.rounds[0].opens.timestamp()
    session.add(_round(competition_id, document.name, CHECK, RoundKind.CHECK, first, secret))
    for number, plan in enumerate(document.rounds, start=1):
        made = _round(
            *(competition_id, document.name, number, plan.kind, plan.opens.timestamp(), secret)
        )
        made.closes_at = plan.closes.timestamp() if isinstance(plan, RoundPlan) else None
        session.add(made)
    session.flush()


def _round(
    competition_id: int, name: str, number: int, kind: RoundKind, opens_at: float, secret: bytes
) -> Round:
    return Round(
        competition_id=competition_id,
        number=number,
        kind=kind,
        opens_at=opens_at,
        commitment=keys.commitment(keys.round_key(secret, name, number)),
    )


def _views(
    session: Session, which: ColumnElement[bool], *, moves: bool = False
) -> list[CompetitionView]:
    teams = select(func.count()).where(Team.competition_id == Competition.id).scalar_subquery()
    query = (
        select(Competition, User.name, Competition.picture.is_not(None), teams)
        .outerjoin(User, User.id == Competition.organiser_id)
        .where(which)
        .order_by(Competition.opened_at.desc(), Competition.id.desc())
        .limit(LISTED_MAX)
    )
    rows = session.execute(query).all()
    rounds = _rounds(session, [row[0] for row in rows])
    files = _files(session, [row[0].id for row in rows])
    if moves:
        rounds = {key: _with_moves(session, each) for key, each in rounds.items()}
    same = ("id", "name", "organiser_id", "digest", "vehicle_sha256", "created_at")
    return [
        CompetitionView(
            **{name: getattr(row, name) for name in (*same, "opened_at", "ended_at")},
            organiser=organiser or "",
            document=_document_of(row),
            has_picture=has_picture,
            files=files.get(row.id, {}),
            teams=count,
            rounds=tuple(rounds[row.id]),
        )
        for row, organiser, has_picture, count in rows
    ]


def _document_of(row: Competition) -> CompetitionDocument:
    """Return the document of a competition."""
    return _document(json.dumps(row.document))


@lru_cache(maxsize=256)
def _document(text: str) -> CompetitionDocument:
    return CompetitionDocument.restore(json.loads(text))


def _files(session: Session, competition_ids: Sequence[int]) -> dict[int, dict[str, str]]:
    """Return competition -> setting -> SHA-256."""
    found = dict[int, dict[str, str]]()
    own = CompetitionFile.competition_id.in_(competition_ids)
    for row in session.scalars(select(CompetitionFile).where(own)):
        found.setdefault(row.competition_id, {})[row.setting] = row.sha256
    return found


def _rounds(session: Session, rows: Sequence[Competition]) -> dict[int, list[RoundView]]:
    documents = {row.id: _document_of(row) for row in rows}
    result: dict[int, list[RoundView]] = {row.id: [] for row in rows}
    numbered = (Round.competition_id.in_(documents), Round.number != CHECK)
    for one in session.scalars(select(Round).where(*numbered).order_by(Round.number)):
        plan = documents[one.competition_id].round(one.number)
        result[one.competition_id].append(_round_view(one, plan))
    return result


def _round_view(row: Round, plan: RoundPlan | Final) -> RoundView:
    """Return the values of a round."""
    same = ("id", "competition_id", "number", "opens_at", "closes_at", "commitment", "key")
    values = {name: getattr(row, name) for name in (*same, "batches", "decided_at")}
    return RoundView(**values, kind=RoundKind(row.kind), plan=plan)


def _with_moves(session: Session, rounds: Sequence[RoundView]) -> list[RoundView]:
    moves = dict[int, list[Move]]()
    made = RoundChange.round_id.in_([one.id for one in rounds])
    for row in session.scalars(select(RoundChange).where(made).order_by(RoundChange.id)):
        move = Move(at=row.at, before=row.before, after=row.after, reason=row.reason)
        moves.setdefault(row.round_id, []).append(move)
    return [replace(one, moves=tuple(moves.get(one.id, ()))) for one in rounds]
