"""Assignments: a benchmark with fixed settings, or its ranked runs, until a deadline.

A run counts for an assignment if it was submitted for it before the deadline, by the clock of the
server; it may end later.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.classes import classrooms
from seamark.server.classes.refusals import ClassRefused
from seamark.server.database.class_tables import AssignedRun, Assignment, Classroom
from seamark.sim import registry
from seamark.sim.engine.seeds import SEED_MAX
from seamark.sim.settings.setting import schema_extras

TITLE_MAX, INSTRUCTIONS_MAX = 120, 8000  # [character]
ASSIGNMENTS_MAX = 200  # of one class
RUNS_MAX = 1000  # of one student for one assignment, so that the teacher's page stays quick
DEADLINE_MAX_S = 10 * 365.25 * 86_400  # from now
PRACTICE, RANKED = "practice", "ranked"


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """What a teacher assigns. `config` may leave out settings that have defaults."""

    title: str
    benchmark: str
    instructions: str = ""
    kind: str = PRACTICE
    config: Mapping[str, object]
    seed: int | None = None  # practice only; None: everybody's own
    trials: int = 1  # practice only
    deadline: float | None = None  # [s since 1970]


@dataclass(frozen=True, slots=True, kw_only=True)
class AssignmentView:
    """An assignment with what its class is called and who teaches it."""

    id: int
    class_id: int
    class_name: str
    teacher_id: int
    shows_ranking: bool
    archived: bool
    title: str
    instructions: str
    benchmark: str
    kind: str
    config: dict[str, Any]
    seed: int | None
    trials: int
    deadline: float | None
    created_at: float

    @property
    def closed(self) -> bool:
        """Whether runs no longer count."""
        return self.archived or (self.deadline is not None and self.deadline <= time.time())

    @property
    def is_ranked(self) -> bool:
        """Whether it asks for ranked runs."""
        return self.kind == RANKED

    def fixed(self) -> dict[str, Any]:
        """Return the settings of the scenario, which no student may change."""
        fields = registry.benchmark(self.benchmark).configuration.model_fields
        return {
            name: value
            for name, value in self.config.items()
            if name in fields and schema_extras(fields[name])["x-role"] != "solution"
        }


def create(session: Session, class_id: int, draft: Draft, *, trials_max: int) -> int:
    """Add an assignment to a class and return its id.

    Raises
    ------
    ClassRefused
        A rule is broken.
    ConfigurationInvalid
        The settings are wrong: a sentence for each.
    """
    if draft.benchmark not in registry.BENCHMARKS:
        raise ClassRefused(f"There is no benchmark {draft.benchmark}.", field="benchmark")
    if draft.kind not in (PRACTICE, RANKED):
        raise ClassRefused("An assignment is for practice or ranked runs.", field="kind")
    ranked = draft.kind == RANKED
    if not ranked:
        _check_practice(draft, trials_max)
    held = select(func.count()).where(Assignment.class_id == class_id)
    if (session.scalar(held) or 0) >= ASSIGNMENTS_MAX:
        raise ClassRefused(f"This class has {ASSIGNMENTS_MAX} assignments. Delete one first.")
    config = registry.benchmark(draft.benchmark).read({} if ranked else draft.config)
    made = Assignment(
        class_id=class_id,
        title=_valid_title(draft.title),
        instructions=_valid_instructions(draft.instructions),
        benchmark=draft.benchmark,
        kind=draft.kind,
        config=config.model_dump(mode="json"),
        seed=None if ranked else draft.seed,
        trials=1 if ranked else draft.trials,
        deadline=_valid_deadline(draft.deadline),
        created_at=time.time(),
    )
    session.add(made)
    session.flush()
    return made.id


def find(session: Session, assignment_id: int) -> AssignmentView | None:
    """Return an assignment; None if it does not exist."""
    row = session.execute(_with_class().where(Assignment.id == assignment_id)).one_or_none()
    return None if row is None else _view(*row)


def of_class(session: Session, class_id: int) -> list[AssignmentView]:
    """Return the assignments of a class, newest first."""
    query = _with_class().where(Assignment.class_id == class_id).order_by(Assignment.id.desc())
    return [_view(*row) for row in session.execute(query.limit(ASSIGNMENTS_MAX))]


def of_run(session: Session, run_id: int) -> AssignmentView | None:
    """Return the assignment that a run was submitted for, or None."""
    query = _with_class().join(AssignedRun, AssignedRun.assignment_id == Assignment.id)
    row = session.execute(query.where(AssignedRun.run_id == run_id)).one_or_none()
    return None if row is None else _view(*row)


def describe(
    session: Session, assignment_id: int, *, title: str, instructions: str, deadline: float | None
) -> None:
    """Change title, text and deadline; the settings stay, since runs were made with them."""
    values = {
        "title": _valid_title(title),
        "instructions": _valid_instructions(instructions),
        "deadline": _valid_deadline(deadline),
    }
    session.execute(update(Assignment).where(Assignment.id == assignment_id).values(**values))


def remove(session: Session, assignment_id: int) -> None:
    """Delete an assignment; the runs stay those of the students."""
    session.execute(delete(Assignment).where(Assignment.id == assignment_id))


def open_for(session: Session, assignment_id: int, user_id: int | None) -> AssignmentView:
    """Return an assignment that this account may submit runs for now; raises ClassRefused."""
    assignment = find(session, assignment_id)
    if assignment is None or not classrooms.has_member(session, assignment.class_id, user_id):
        raise ClassRefused("You are not in the class of this assignment.", field="assignment")
    if assignment.archived:
        raise ClassRefused(f"The class {assignment.class_name} is archived.", field="assignment")
    if assignment.closed:
        raise ClassRefused(
            f"The deadline of the assignment “{assignment.title}” has passed.", field="assignment"
        )
    return assignment


def enter(session: Session, assignment_id: int, user_id: int, run_id: int) -> None:
    """Record that a run was submitted for an assignment, in the transaction that inserts it.

    Raises
    ------
    ClassRefused
        The deadline has passed, the account is not in the class, or it made too many runs.
    """
    open_for(session, assignment_id, user_id)
    own = (AssignedRun.assignment_id == assignment_id, AssignedRun.user_id == user_id)
    if (session.scalar(select(func.count()).where(*own)) or 0) >= RUNS_MAX:
        raise ClassRefused(f"You have made {RUNS_MAX} runs for this assignment.")
    session.add(AssignedRun(run_id=run_id, assignment_id=assignment_id, user_id=user_id))


def score(session: Session, run_id: int, value: float | None) -> None:
    """Record the score of a run that has succeeded, in the transaction that stores its result."""
    change = update(AssignedRun).where(AssignedRun.run_id == run_id)
    session.execute(change.values(score=value))


def _with_class() -> Any:
    return select(Assignment, Classroom).join(Classroom, Classroom.id == Assignment.class_id)


def _view(row: Assignment, room: Classroom) -> AssignmentView:
    same = ("id", "title", "instructions", "benchmark", "kind", "config", "seed", "trials")
    return AssignmentView(
        **{name: getattr(row, name) for name in (*same, "deadline", "created_at")},
        class_id=room.id,
        class_name=room.name,
        teacher_id=room.teacher_id,
        shows_ranking=room.shows_ranking,
        archived=room.archived_at is not None,
    )


def _check_practice(draft: Draft, trials_max: int) -> None:
    if not 1 <= draft.trials <= trials_max:
        raise ClassRefused(f"A practice run has 1 to {trials_max} trials.", field="trials")
    if draft.seed is not None and not 0 <= draft.seed <= SEED_MAX:
        raise ClassRefused(f"A seed is a whole number from 0 to {SEED_MAX}.", field="seed")


def _valid_title(title: str) -> str:
    title = visible_text(title).strip()
    if not 1 <= len(title) <= TITLE_MAX:
        raise ClassRefused(
            f"An assignment has a title of 1 to {TITLE_MAX} characters.", field="title"
        )
    return title


def _valid_instructions(text: str) -> str:
    text = visible_text(text, keep="\n\t").strip()
    if len(text) > INSTRUCTIONS_MAX:
        raise ClassRefused(
            f"The instructions are limited to {INSTRUCTIONS_MAX} characters.", field="instructions"
        )
    return text


def _valid_deadline(deadline: float | None) -> float | None:
    if deadline is not None and not 0 < deadline < time.time() + DEADLINE_MAX_S:
        raise ClassRefused("The deadline must be within ten years.", field="deadline")
    return deadline
