"""Classes: a teacher makes one and hands out its code or link; students join and leave."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import ColumnElement, Select, delete, func, select, update
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts import join_codes
from seamark.server.classes.refusals import ClassRefused
from seamark.server.database.class_tables import AssignedRun, Assignment, Classroom, Membership
from seamark.server.database.tables import User

NAME_MAX = 80  # [character]
CLASSES_MAX = 200  # of one teacher
PUPILS_MAX = 2000  # of one class
JOINED_MAX = 50  # classes that one student may belong to
PAGE = 50  # students on a page
UNKNOWN_CODE = "No class has this code or link any more. Ask your teacher for the current one."


@dataclass(frozen=True, slots=True)
class ClassView:
    """A class as its teacher or a student sees it; the code is for the teacher alone."""

    id: int
    name: str
    teacher_id: int
    teacher: str
    code: str
    shows_ranking: bool
    created_at: float
    archived_at: float | None
    pupils: int


@dataclass(frozen=True, slots=True)
class Pupil:
    """A student of a class."""

    user_id: int
    name: str
    joined_at: float


def create(session: Session, teacher_id: int, name: str) -> int:
    """Make a class with a new code and return its id; raises ClassRefused."""
    name = _valid_name(name)
    own = select(func.count()).where(Classroom.teacher_id == teacher_id)
    if (session.scalar(own) or 0) >= CLASSES_MAX:
        raise ClassRefused(f"You have {CLASSES_MAX} classes. Delete one you no longer need.")
    made = Classroom(
        teacher_id=teacher_id,
        name=name,
        code=join_codes.new(),
        created_at=time.time(),
        archived_at=None,
    )
    session.add(made)
    session.flush()
    return made.id


def find(session: Session, class_id: int) -> ClassView | None:
    """Return a class; None if it does not exist."""
    return next(iter(_views(session, Classroom.id == class_id)), None)


def taught_by(session: Session, user_id: int) -> list[ClassView]:
    """Return the classes of a teacher, newest first, archived ones last."""
    return _views(session, Classroom.teacher_id == user_id)


def joined_by(session: Session, user_id: int) -> list[ClassView]:
    """Return the classes that a student belongs to, newest first, archived ones last."""
    joined = select(Membership.class_id).where(Membership.user_id == user_id)
    return _views(session, Classroom.id.in_(joined))


def opened_by(session: Session, code: str) -> ClassView | None:
    """Return the class that people can join with this code, or a link that ends with it."""
    is_open = (Classroom.code == join_codes.read(code)) & Classroom.archived_at.is_(None)
    return next(iter(_views(session, is_open)), None)


def has_member(session: Session, class_id: int, user_id: int | None) -> bool:
    """Return whether an account is a student of a class."""
    return user_id is not None and session.get(Membership, (class_id, user_id)) is not None


def join(session: Session, user_id: int, code: str) -> int:
    """Add an account to the class with this code, or link, and return the class's id.

    Joining again changes nothing.

    Raises
    ------
    ClassRefused
        There is no such class, it is archived or full, or it is the account's own.
    """
    classroom = opened_by(session, code)
    if classroom is None:
        raise ClassRefused(UNKNOWN_CODE)
    if classroom.teacher_id == user_id:
        raise ClassRefused("This is your own class.")
    if has_member(session, classroom.id, user_id):
        return classroom.id
    if classroom.pupils >= PUPILS_MAX:
        raise ClassRefused(f"This class already has {PUPILS_MAX} students.")
    joined = select(func.count()).where(Membership.user_id == user_id)
    if (session.scalar(joined) or 0) >= JOINED_MAX:
        raise ClassRefused(f"You are in {JOINED_MAX} classes. Leave one first.")
    session.add(Membership(class_id=classroom.id, user_id=user_id, joined_at=time.time()))
    return classroom.id


def leave(session: Session, class_id: int, user_id: int) -> bool:
    """End a membership; False if there is none.

    The runs stay the student's. The teacher no longer sees them, unless the student joins again.
    """
    own = (Membership.class_id == class_id, Membership.user_id == user_id)
    gone = session.scalar(delete(Membership).where(*own).returning(Membership.user_id))
    return gone is not None


def change(
    session: Session,
    class_id: int,
    *,
    name: str | None = None,
    shows_ranking: bool | None = None,
    archived: bool | None = None,
    new_code: bool = False,
) -> None:
    """Change what is given; raises ClassRefused. Nobody joins or submits to an archived class."""
    values: dict[str, object] = {}
    if name is not None:
        values["name"] = _valid_name(name)
    if shows_ranking is not None:
        values["shows_ranking"] = shows_ranking
    if archived is not None:
        values["archived_at"] = time.time() if archived else None
    if new_code:
        values["code"] = join_codes.new()
    if values:
        session.execute(update(Classroom).where(Classroom.id == class_id).values(**values))


def remove(session: Session, class_id: int) -> None:
    """Delete a class with its assignments; the runs stay those of the students."""
    session.execute(delete(Classroom).where(Classroom.id == class_id))


def pupils(session: Session, class_id: int, *, after: str = "") -> list[Pupil]:
    """Return the students of a class in the order of their names, those after a name."""
    query = (
        select(User.id, User.name, Membership.joined_at)
        .join(Membership, Membership.user_id == User.id)
        .where(Membership.class_id == class_id, User.name_key > after.casefold())
        .order_by(User.name_key)
        .limit(PAGE)
    )
    return [Pupil(*row) for row in session.execute(query)]


def teacher_of(session: Session, run_id: int) -> int | None:
    """Return who teaches the class that a run was submitted for, while its owner is in it."""
    query = (
        select(Classroom.teacher_id)
        .join(Assignment, Assignment.class_id == Classroom.id)
        .join(AssignedRun, AssignedRun.assignment_id == Assignment.id)
        .join(
            Membership,
            (Membership.class_id == Classroom.id) & (Membership.user_id == AssignedRun.user_id),
        )
        .where(AssignedRun.run_id == run_id)
    )
    return session.scalar(query)


def _views(session: Session, condition: ColumnElement[bool]) -> list[ClassView]:
    query = (
        select(Classroom, User.name, _pupils_of(Classroom.id).scalar_subquery())
        .join(User, User.id == Classroom.teacher_id)
        .where(condition)
        .order_by(Classroom.archived_at.is_not(None), Classroom.id.desc())
        .limit(CLASSES_MAX)
    )
    same: Sequence[str] = ("id", "name", "teacher_id", "shows_ranking", "created_at", "archived_at")
    return [
        ClassView(
            **{name: getattr(room, name) for name in same},
            teacher=teacher,
            code=join_codes.shown(room.code),
            pupils=count,
        )
        for room, teacher, count in session.execute(query)
    ]


def _pupils_of(class_id: object) -> Select[int]:
    return select(func.count(Membership.user_id)).where(Membership.class_id == class_id)


def _valid_name(name: str) -> str:
    name = visible_text(name).strip()
    if not 1 <= len(name) <= NAME_MAX:
        raise ClassRefused(f"A class has a name of 1 to {NAME_MAX} characters.")
    return name
