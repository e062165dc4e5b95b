"""Who calls the routes of the access matrix, and the rules of what a caller may do.

Written here independently of `seamark.server.accounts.permissions`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain, combinations

READ, SUBMIT, ADMIN = "read", "submit", "admin"
SETS = [
    frozenset(scopes)
    for scopes in chain(*(combinations((READ, SUBMIT, ADMIN), count) for count in (1, 2, 3)))
]
ALL = frozenset({READ, SUBMIT, ADMIN})
REFUSED = {401, 403, 404}
TO_SIGN_IN = "/sign-in?next="


@dataclass(frozen=True)
class Caller:
    """A role, and the scopes of its token; a browser has a cookie and no token."""

    role: str  # "anonymous", "guest", or a name of the cast: ann owns, ben does not, see ROLES.
    # In a competition olga organises, ann is captain and eva a member of a team, otto an organiser
    # of other competitions, and the others are in no team.
    scopes: frozenset[str] | None = None

    def __str__(self) -> str:
        return self.role if self.scopes is None else f"{self.role}-{'+'.join(sorted(self.scopes))}"

    def has(self, scope: str) -> bool:
        return self.scopes is None or scope in self.scopes

    @property
    def signed_in(self) -> bool:
        return self.role in ROLES

    def is_at_least(self, role: str) -> bool:
        """Return whether the rights of a role apply, which need the scope "admin"."""
        return self.signed_in and RANK[ROLES[self.role]] >= RANK[role] and self.has(ADMIN)

    @property
    def administers(self) -> bool:
        return self.is_at_least("admin")


RANK = {"user": 0, "teacher": 1, "organiser": 2, "admin": 3}
ROLES = {"ann": "user", "ben": "user", "eva": "user", "tim": "teacher"}
ROLES |= {"olga": "organiser", "otto": "organiser", "root": "admin"}
# The scope "admin" of a user has no effect: one such token for each.
OF_USER = [scopes for scopes in SETS if scopes == ALL or ADMIN not in scopes]
CALLERS = [
    Caller("anonymous"),
    Caller("guest"),
    *(Caller(name, scopes) for name in ("tim", "olga", "root") for scopes in (None, *SETS)),
    *(Caller("ann", scopes) for scopes in (None, *OF_USER)),
    *(Caller(name, scopes) for name in ("ben", "eva", "otto") for scopes in (None, ALL)),
]
Allows = Callable[[Caller], bool]


def everybody(caller: Caller) -> bool:
    return True


def lists(caller: Caller) -> bool:
    return caller.has(READ)


def submits(caller: Caller) -> bool:
    return caller.has(SUBMIT)


def submits_as_somebody(caller: Caller) -> bool:
    return caller.has(SUBMIT) and caller.role != "anonymous"


def uploads(caller: Caller) -> bool:
    return caller.signed_in and caller.has(SUBMIT)


def connects(caller: Caller) -> bool:
    return uploads(caller) and caller.scopes is not None  # no cookie will do


def reads_account(caller: Caller) -> bool:
    return caller.signed_in and caller.has(READ)


def changes_tokens(caller: Caller) -> bool:
    return caller.signed_in and caller.has(SUBMIT)


def reads_its_own(caller: Caller) -> bool:
    return caller.role == "ann" and caller.has(READ)


def changes_its_own(caller: Caller) -> bool:
    return caller.role == "ann" and caller.has(SUBMIT)


def changes_password(caller: Caller) -> bool:
    return caller.signed_in and caller.scopes is None


def reads_run(caller: Caller) -> bool:
    return caller.has(READ) and (caller.role == "ann" or caller.administers)


def changes_run(caller: Caller) -> bool:
    return caller.has(SUBMIT) and (caller.role == "ann" or caller.administers)


def withdraws(caller: Caller) -> bool:
    return caller.has(SUBMIT) and (caller.role == "ann" or caller.is_at_least("organiser"))


def administers(caller: Caller) -> bool:
    return caller.administers


def invites(caller: Caller) -> bool:
    return caller.is_at_least("teacher")


def teaches(caller: Caller) -> bool:
    return caller.has(READ) and (caller.role == "tim" or caller.administers) and caller.has(ADMIN)


def organises(caller: Caller) -> bool:
    return caller.has(ADMIN) and caller.role in {"olga", "root"}


def holds_competitions(caller: Caller) -> bool:
    return caller.is_at_least("organiser")


def reads_team(caller: Caller) -> bool:
    return caller.role in {"ann", "eva"} and caller.has(READ)


def leaves_team(caller: Caller) -> bool:
    return caller.role in {"ann", "eva"} and caller.has(SUBMIT)


def has_classes(caller: Caller) -> bool:
    return caller.is_at_least("teacher")


def sees_class(caller: Caller) -> bool:
    return reads_its_own(caller) or teaches(caller)
