"""Permissions: the only place that decides who may do what, for pages and the API alike."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Protocol

READ, SUBMIT, ADMIN = "read", "submit", "admin"
SCOPES: tuple[str, ...] = (READ, SUBMIT, ADMIN)
GUESTS = "guest:"  # start of the owner of a guest's runs
REJUDGEMENTS = "rejudgement:"  # of runs that compute others again
VERIFICATIONS = f"{REJUDGEMENTS}verifications"  # of those that do so on fresh trials


class Role(IntEnum):
    """What someone is to the service; each may do what those before it may."""

    ANONYMOUS = 0
    GUEST = 1  # known by a cookie
    USER = 2
    TEACHER = 3  # invites people to sign up, has classes and reads what students submit for them
    ORGANISER = 4  # holds competitions, takes published runs off the leaderboards
    ADMIN = 5

    @property
    def label(self) -> str:
        """The name that people, the API and the database use."""
        return self.name.lower()


ACCOUNT_ROLES: Sequence[Role] = (Role.USER, Role.TEACHER, Role.ORGANISER, Role.ADMIN)


class Action(StrEnum):
    """What a viewer may do; the second group applies to one run."""

    LIST = "list"
    SUBMIT = "submit"
    UPLOAD = "upload"
    SUBMIT_RANKED = "submit_ranked"
    VIEW_ACCOUNT = "view_account"
    MANAGE_TOKENS = "manage_tokens"
    CHANGE_PASSWORD = "change_password"  # noqa: S105 - the name of an action
    CLOSE_ACCOUNT = "close_account"
    EDIT_PROFILE = "edit_profile"
    VIEW_CLASSES = "view_classes"
    JOIN_CLASSES = "join_classes"
    TEACH = "teach"
    INVITE = "invite"
    COMPETE = "compete"  # found teams, join and leave them, enter competitions
    ORGANISE = "organise"  # competitions
    MODERATE = "moderate"  # withdraw the published runs of others
    ADMINISTER = "administer"

    VIEW = "view"
    VIEW_PROGRAM = "view_program"
    VIEW_LOG = "view_log"
    CANCEL = "cancel"
    PUBLISH = "publish"
    VERIFY = "verify"  # have a public ranked run evaluated again
    WITHDRAW = "withdraw"
    RERUN = "rerun"
    DELETE_DATA = "delete_data"
    EDIT = "edit"  # title and notes
    DELETE = "delete"


@dataclass(frozen=True, slots=True)
class Rule:
    """What an action requires of everybody; what it requires of a run is in `_may_on_run`."""

    scope: str
    role: Role  # at least
    in_browser: bool = False  # no token will do


RULES: Mapping[Action, Rule] = {
    Action.LIST: Rule(READ, Role.ANONYMOUS),
    Action.SUBMIT: Rule(SUBMIT, Role.GUEST),
    Action.UPLOAD: Rule(SUBMIT, Role.USER),
    Action.SUBMIT_RANKED: Rule(SUBMIT, Role.USER),
    Action.VIEW_ACCOUNT: Rule(READ, Role.USER),
    Action.MANAGE_TOKENS: Rule(SUBMIT, Role.USER),
    Action.CHANGE_PASSWORD: Rule(SUBMIT, Role.USER, in_browser=True),
    Action.CLOSE_ACCOUNT: Rule(SUBMIT, Role.USER, in_browser=True),
    Action.VIEW_CLASSES: Rule(READ, Role.USER),
    Action.JOIN_CLASSES: Rule(SUBMIT, Role.USER),
    Action.TEACH: Rule(ADMIN, Role.TEACHER),
    Action.INVITE: Rule(ADMIN, Role.TEACHER),
    Action.COMPETE: Rule(SUBMIT, Role.USER),
    Action.ORGANISE: Rule(ADMIN, Role.ORGANISER),
    Action.MODERATE: Rule(ADMIN, Role.ORGANISER),
    Action.ADMINISTER: Rule(ADMIN, Role.ADMIN),
    Action.EDIT_PROFILE: Rule(SUBMIT, Role.USER),
    Action.VIEW: Rule(READ, Role.ANONYMOUS),
    Action.VIEW_PROGRAM: Rule(READ, Role.ANONYMOUS),
    Action.VIEW_LOG: Rule(READ, Role.ANONYMOUS),
    Action.CANCEL: Rule(SUBMIT, Role.GUEST),
    Action.PUBLISH: Rule(SUBMIT, Role.USER),  # a guest has no name to publish under
    Action.VERIFY: Rule(SUBMIT, Role.USER),
    Action.WITHDRAW: Rule(SUBMIT, Role.GUEST),
    Action.RERUN: Rule(SUBMIT, Role.GUEST),
    Action.DELETE_DATA: Rule(SUBMIT, Role.GUEST),
    Action.EDIT: Rule(SUBMIT, Role.GUEST),
    Action.DELETE: Rule(SUBMIT, Role.GUEST),
}
_READS = {Action.VIEW, Action.VIEW_PROGRAM, Action.VIEW_LOG}
_CHANGES = {
    *(Action.CANCEL, Action.PUBLISH, Action.VERIFY, Action.WITHDRAW, Action.RERUN),
    *(Action.EDIT, Action.DELETE, Action.DELETE_DATA),
}
_ON_RUN = _READS | _CHANGES


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewer:
    """Who sent a request: a user, a guest identified by a cookie, or an anonymous visitor."""

    user_id: int | None = None
    name: str = ""
    account_role: Role = Role.USER  # of `user_id`
    guest: str | None = None  # hash of the cookie
    network: str | None = None  # hash of the address prefix of a guest or an anonymous visitor
    scopes: frozenset[str] = frozenset(SCOPES)  # fewer for a token
    token_expires_at: float | None = None  # [s since 1970]; None without a token

    @property
    def owner(self) -> str | None:
        """The key under which this viewer's runs are queued and counted; None if anonymous.

        All guests of a network have one, since a new cookie costs nothing.
        """
        if self.user_id is not None:
            return f"user:{self.user_id}"
        return None if self.guest is None else f"{GUESTS}{self.network or self.guest}"

    @property
    def role(self) -> Role:
        """The role, whatever the scopes."""
        if self.user_id is not None:
            return self.account_role
        return Role.ANONYMOUS if self.guest is None else Role.GUEST


class Entered(Protocol):
    """What `can` needs to know about the entry of a competition."""

    @property
    def members(self) -> frozenset[int]: ...  # noqa: D102 - of the team
    def seen_by(self, user_id: int | None, *, program: bool) -> bool: ...  # noqa: D102


class Owned(Protocol):
    """What `can` needs to know about a run; RunView provides it."""

    @property
    def user_id(self) -> int | None: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def guest(self) -> str | None: ...  # noqa: D102
    @property
    def public(self) -> bool: ...  # noqa: D102
    @property
    def program_public(self) -> bool: ...  # noqa: D102 - False: only the results are published
    @property
    def teacher_id(self) -> int | None: ...  # noqa: D102 - of the class it was submitted for
    @property
    def entry(self) -> Entered | None: ...  # noqa: D102 - of a competition


def can(viewer: Viewer, action: Action, run: Owned | None = None) -> bool:
    """Return whether `viewer` may perform `action`, on `run` if it applies to a run."""
    rule = RULES[action]
    if run is not None and _everybody_may(action, run):
        return True  # so no scope is needed
    if viewer.role < rule.role or rule.scope not in viewer.scopes:
        return False
    if rule.in_browser and viewer.token_expires_at is not None:
        return False
    if action not in _ON_RUN:
        return True
    return run is not None and _may_on_run(viewer, action, run)


def _everybody_may(action: Action, run: Owned) -> bool:
    return run.public and (action is Action.VIEW or (action in _READS and run.program_public))


def grantable(viewer: Viewer) -> tuple[str, ...]:
    """Return the scopes that a new token of the viewer may have: none the viewer lacks."""
    own = [scope for scope in SCOPES if scope in viewer.scopes]
    return tuple(scope for scope in own if scope != ADMIN or viewer.role > Role.USER)


def _may_on_run(viewer: Viewer, action: Action, run: Owned) -> bool:
    """Decide for a private run, or for an action other than reading."""
    if owns(viewer, run):
        return True
    if action is Action.RERUN:
        return run.public and run.program_public
    if run.entry is not None:
        return _may_on_entry(viewer, action, run.entry)
    if action is Action.WITHDRAW and run.public and can(viewer, Action.MODERATE):
        return True
    if action in _READS and run.teacher_id is not None and teaches(viewer, run.teacher_id):
        return True
    return can(viewer, Action.ADMINISTER)


def _may_on_entry(viewer: Viewer, action: Action, entry: Entered) -> bool:
    """Decide for a run that counts in a competition: it belongs to a team.

    Even an admin neither deletes nor publishes one, which would change a result.
    """
    seen = entry.seen_by(viewer.user_id, program=action is not Action.VIEW)
    if action is Action.CANCEL:
        seen = seen and viewer.user_id in entry.members
    elif action not in _READS:
        return False
    return seen or can(viewer, Action.ADMINISTER)


def teaches(viewer: Viewer, teacher_id: int) -> bool:
    """Return whether the viewer has the rights of this teacher: is it, or is an admin."""
    own = viewer.user_id == teacher_id and can(viewer, Action.TEACH)
    return own or can(viewer, Action.ADMINISTER)


def organises(viewer: Viewer, organiser_id: int | None) -> bool:
    """Return whether the viewer has the rights of this organiser: is it, or is an admin."""
    own = viewer.user_id is not None and viewer.user_id == organiser_id
    return (own and can(viewer, Action.ORGANISE)) or can(viewer, Action.ADMINISTER)


def owns(viewer: Viewer, run: Owned) -> bool:
    """Return whether the run is the viewer's own."""
    if run.user_id is not None:
        return run.user_id == viewer.user_id
    return run.guest is not None and viewer.user_id is None and run.guest == viewer.guest
