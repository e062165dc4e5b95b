from dataclasses import dataclass, replace

import pytest

from seamark.competitions.document import RoundKind
from seamark.server.accounts.permissions import READ, SCOPES, SUBMIT, Action, Role, Viewer, can
from seamark.server.runs.record.entries import EntryAccess


@dataclass(frozen=True)
class Thing:
    user_id: int | None
    guest: str | None
    public: bool
    teacher_id: int | None = None
    program_public: bool = True
    entry: EntryAccess | None = None


PRIVATE, PUBLIC = Thing(1, None, public=False), Thing(1, None, public=True)
RESULTS = Thing(1, None, public=True, program_public=False)  # alone
ASSIGNED = Thing(1, None, public=False, teacher_id=4)  # by TEACHER
GUESTS = Thing(None, "g", public=False)
ENTERED = EntryAccess(  # by a team of OWNER and OTHER, in a competition of ORGANISER
    competition="cup-v1",
    title="Cup",
    round=2,
    kind=RoundKind.QUALIFICATION,
    batch=0,
    method="PI",
    team_id=9,
    team="Reef",
    members=frozenset({1, 2}),
    organiser_id=5,
    organiser_reads=False,
    sealed=False,
)
ENTRY = Thing(None, None, public=False, entry=ENTERED)
READABLE = replace(ENTRY, entry=replace(ENTERED, organiser_reads=True))
SEALED = replace(ENTRY, entry=replace(ENTERED, organiser_reads=True, sealed=True))
DECIDED = replace(ENTRY, public=True, program_public=False)
OWNER, OTHER = Viewer(user_id=1), Viewer(user_id=2)
ADMIN = Viewer(user_id=3, account_role=Role.ADMIN)
TEACHER = Viewer(user_id=4, account_role=Role.TEACHER)
ORGANISER = Viewer(user_id=5, account_role=Role.ORGANISER)
GUEST, OTHER_GUEST, NOBODY = Viewer(guest="g"), Viewer(guest="h"), Viewer()
READING = {"list", "view_account", "view_classes"}
OF_USER = READING | {
    "submit", "upload", "submit_ranked", "manage_tokens", "edit_profile", "join_classes", "compete"
}  # fmt: skip
IN_BROWSER = {"change_password", "close_account"}
OF_TEACHER = {"invite", "teach"}
OF_ORGANISER = {"moderate", "organise"}
LOOK = {Action.VIEW, Action.VIEW_PROGRAM, Action.VIEW_LOG}
CHANGE = {Action.CANCEL, Action.PUBLISH, Action.VERIFY, Action.WITHDRAW, Action.RERUN}
CHANGE |= {Action.DELETE_DATA}
ON_RUN = LOOK | CHANGE


@pytest.mark.parametrize(
    ("viewer", "run", "allowed"),
    [
        (OWNER, PRIVATE, ON_RUN),
        (OWNER, PUBLIC, ON_RUN),
        (OTHER, PRIVATE, set()),
        (OTHER, PUBLIC, LOOK | {Action.RERUN}),
        (ADMIN, PRIVATE, ON_RUN - {Action.RERUN}),
        (ADMIN, PUBLIC, ON_RUN),
        (GUEST, GUESTS, ON_RUN - {Action.PUBLISH, Action.VERIFY}),
        (GUEST, PRIVATE, set()),
        (OTHER_GUEST, GUESTS, set()),
        (OTHER_GUEST, PUBLIC, LOOK | {Action.RERUN}),
        (NOBODY, PRIVATE, set()),
        (OTHER, RESULTS, {Action.VIEW}),
        (OWNER, RESULTS, ON_RUN),
        (NOBODY, GUESTS, set()),
        (NOBODY, PUBLIC, LOOK),
        (OTHER, GUESTS, set()),
        (Viewer(user_id=1, scopes=frozenset({READ})), PRIVATE, LOOK),
        (Viewer(user_id=1, scopes=frozenset({SUBMIT})), PRIVATE, ON_RUN - LOOK),
        (Viewer(user_id=3, account_role=Role.ADMIN, scopes=frozenset({READ})), PRIVATE, set()),
        (OWNER, ENTRY, LOOK | {Action.CANCEL}),
        (OTHER, ENTRY, LOOK | {Action.CANCEL}),
        (TEACHER, ENTRY, set()),
        (ORGANISER, ENTRY, {Action.VIEW}),
        (ORGANISER, READABLE, LOOK),
        (ORGANISER, SEALED, set()),
        (OWNER, SEALED, set()),
        (ADMIN, SEALED, LOOK | {Action.CANCEL}),
        (NOBODY, ENTRY, set()),
        (GUEST, ENTRY, set()),
        (NOBODY, DECIDED, {Action.VIEW}),
        (OTHER, DECIDED, LOOK | {Action.CANCEL}),
        (replace(ORGANISER, user_id=7), ENTRY, set()),
        (replace(ORGANISER, user_id=7), DECIDED, {Action.VIEW}),
        (TEACHER, PRIVATE, set()),
        (TEACHER, PUBLIC, LOOK | {Action.RERUN}),
        (TEACHER, ASSIGNED, LOOK),
        (replace(TEACHER, scopes=frozenset({READ, SUBMIT})), ASSIGNED, set()),
        (replace(TEACHER, account_role=Role.USER), ASSIGNED, set()),
        (replace(TEACHER, user_id=6), ASSIGNED, set()),
        (OWNER, ASSIGNED, ON_RUN),
        (ORGANISER, ASSIGNED, set()),
        (ORGANISER, PRIVATE, set()),
        (ORGANISER, GUESTS, set()),
        (ORGANISER, PUBLIC, LOOK | {Action.RERUN, Action.WITHDRAW}),
        (replace(ORGANISER, scopes=frozenset({READ, SUBMIT})), PUBLIC, LOOK | {Action.RERUN}),
    ],
)
def test_a_viewer_may_do_to_a_run_exactly_what_the_table_allows(
    viewer: Viewer, run: Thing, allowed: set[Action]
) -> None:
    assert {action for action in ON_RUN if can(viewer, action, run)} == allowed


@pytest.mark.parametrize(
    ("viewer", "allowed"),
    [
        (OWNER, OF_USER | IN_BROWSER),
        (TEACHER, OF_USER | IN_BROWSER | OF_TEACHER),
        (ORGANISER, OF_USER | IN_BROWSER | OF_TEACHER | OF_ORGANISER),
        (ADMIN, OF_USER | IN_BROWSER | OF_TEACHER | OF_ORGANISER | {"administer"}),
        (GUEST, {"list", "submit"}),
        (NOBODY, {"list"}),
        (Viewer(user_id=1, scopes=frozenset({READ})), READING),
        (Viewer(user_id=1, token_expires_at=1.0, scopes=frozenset({SUBMIT})), OF_USER - READING),
        (Viewer(user_id=1, token_expires_at=1.0), OF_USER),
        (Viewer(user_id=3, account_role=Role.ADMIN, scopes=frozenset({READ})), READING),
        (replace(TEACHER, scopes=frozenset({READ, SUBMIT}), token_expires_at=1.0), OF_USER),
        (Viewer(user_id=1, scopes=frozenset({"admin"})), set()),
    ],
)
def test_a_viewer_may_do_without_a_run_exactly_what_the_table_allows(
    viewer: Viewer, allowed: set[str]
) -> None:
    assert {action for action in set(Action) - ON_RUN if can(viewer, action)} == allowed


def test_actions_on_a_run_are_denied_without_a_run() -> None:
    assert not any(can(ADMIN, action) for action in ON_RUN)


def test_a_viewer_has_all_scopes_by_default() -> None:
    assert Viewer().scopes == set(SCOPES)
