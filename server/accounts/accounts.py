"""Accounts, passwords and tokens."""

import hashlib
import hmac
import re
import secrets
import time
from collections.abc import Iterable

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import SCOPES, Viewer
from seamark.server.database.tables import Run, Token, User
from seamark.server.settings import Settings

NAME_RULE = "2 to 40 letters, digits, dots, dashes or underscores, starting with a letter"
RESERVED = frozenset({"guest"})  # who has no account
RESERVED_PREFIX = "seamark"  # the owners of the baselines
PASSWORD_MIN, PASSWORD_MAX = 10, 200
TOKEN_PREFIX = "smk_"  # noqa: S105 - lets secret scanners recognise our tokens
TOKEN_DAYS = 90
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9._-]{1,39}")
_DAY_S = 86_400.0
_USED_STEP_S = 60.0  # `last_used_at` is written at most this often
_hasher = PasswordHasher()
# Checked when the name is unknown, so that the time of the answer does not tell which names exist.
_NOBODY = _hasher.hash(secrets.token_hex(16))


class AccountRejected(Exception):
    """An account cannot be made or changed so. The text is for the form."""


def sign_up(session: Session, name: str, password: str | None, *, is_admin: bool = False) -> User:
    """Make an account; raises AccountRejected. Without a password nobody can log in to it."""
    if not _NAME.fullmatch(name):
        raise AccountRejected(f"A name has {NAME_RULE}.")
    if name.casefold() in RESERVED or name.casefold().startswith(RESERVED_PREFIX):
        raise AccountRejected(f"The name {name} is taken.")
    if password is not None:
        _check_password(password)
    if session.scalar(select(User.id).where(User.name_key == name.casefold())) is not None:
        raise AccountRejected(f"The name {name} is taken.")
    user = User(
        name=name,
        name_key=name.casefold(),
        password_hash=None if password is None else _hasher.hash(password),
        is_admin=is_admin,
        created_at=time.time(),
    )
    session.add(user)
    session.flush()
    return user


def authenticate(session: Session, name: str, password: str) -> User | None:
    """Return the user if the password is right; takes as long for an unknown name."""
    user = session.scalar(select(User).where(User.name_key == name.casefold()))
    known = user.password_hash if user is not None and user.password_hash else _NOBODY
    try:
        _hasher.verify(known, password[: PASSWORD_MAX + 1])
    except (VerificationError, InvalidHashError):
        return None
    return None if known is _NOBODY else user


def adopt_runs(session: Session, user_id: int, guest: str) -> int:
    """Give a guest's runs, by the hash of the cookie, to a user; return how many there were."""
    mine = f"user:{user_id}"
    change = update(Run).where(Run.owner == f"guest:{guest}", Run.guest == guest)
    taken = session.scalars(
        change.values(owner=mine, user_id=user_id, guest=None).returning(Run.id)
    )
    return len(taken.all())


def change_password(session: Session, name: str, old: str | None, new: str) -> User:
    """Set a new password and return the user; browsers signed in with the old one are out.

    With `old` the present password is asked for; None is for who runs the service.

    Raises
    ------
    AccountRejected
        There is no such account, the old password is wrong or the new one breaks a rule.
    """
    if old is not None and authenticate(session, name, old) is None:
        raise AccountRejected("The present password is not right.")
    user = session.scalar(select(User).where(User.name_key == name.casefold()))
    if user is None or user.is_baseline:
        raise AccountRejected(f"There is no account {name}.")
    _check_password(new)
    user.password_hash = _hasher.hash(new)
    return user


def session_key(settings: Settings, user: User) -> str:
    """Return what a browser's cookie holds beside the user's id: another one for each password."""
    text = f"session {user.id} {user.password_hash}"
    return hmac.new(settings.secret_key.encode(), text.encode(), "sha256").hexdigest()[:32]


def viewer_of_session(
    session: Session, user_id: int, key: str, settings: Settings
) -> Viewer | None:
    """Return whom a browser speaks for; None if the account is gone or has another password."""
    user = session.get(User, user_id)
    if user is None or not hmac.compare_digest(session_key(settings, user), key):
        return None
    return _viewer(user, SCOPES)


def guest_hash(settings: Settings, cookie: str) -> str:
    """Return what the database keeps of a guest's cookie; the cookie cannot be found from it."""
    return hmac.new(settings.secret_key.encode(), f"guest {cookie}".encode(), "sha256").hexdigest()


def new_token(
    session: Session, user_id: int, name: str, scopes: Iterable[str], *, days: float = TOKEN_DAYS
) -> str:
    """Make a token and return its text, which is not kept and cannot be shown again."""
    wanted = sorted(set(scopes))
    if unknown := set(wanted) - set(SCOPES):
        raise AccountRejected(f"There is no scope {', '.join(sorted(unknown))}.")
    if not wanted:
        raise AccountRejected("A token needs at least one scope.")
    text = TOKEN_PREFIX + secrets.token_urlsafe(32)
    now = time.time()
    token = Token(
        user_id=user_id,
        name=name.strip()[:80] or "token",
        hash=_token_hash(text),
        scopes=wanted,
        created_at=now,
        expires_at=now + days * _DAY_S,
    )
    session.add(token)
    session.flush()
    return text


def tokens(session: Session, user_id: int) -> list[Token]:
    """Return a user's tokens, newest first."""
    query = select(Token).where(Token.user_id == user_id).order_by(Token.id.desc())
    return list(session.scalars(query))


def revoke_token(session: Session, user_id: int, token_id: int) -> bool:
    """Delete one of the user's tokens; False if there is no such token."""
    gone = delete(Token).where(Token.id == token_id, Token.user_id == user_id)
    return session.scalar(gone.returning(Token.id)) is not None


def viewer_of_token(session: Session, text: str) -> Viewer | None:
    """Return whom a token speaks for, or None if it is unknown or has expired.

    Only reads; `note_use` records that the token was used.
    """
    query = select(Token, User).join(User, User.id == Token.user_id)
    row = session.execute(query.where(Token.hash == _token_hash(text))).one_or_none()
    if row is None:
        return None
    token, user = row
    if token.expires_at is not None and token.expires_at <= time.time():
        return None
    return _viewer(user, token.scopes)


def note_use(session: Session, text: str) -> None:
    """Record that a token was used, at most once a minute."""
    now = time.time()
    stale = (Token.last_used_at.is_(None)) | (Token.last_used_at < now - _USED_STEP_S)
    session.execute(
        update(Token).where(Token.hash == _token_hash(text), stale).values(last_used_at=now)
    )


def _viewer(user: User, scopes: Iterable[str]) -> Viewer:
    return Viewer(user_id=user.id, name=user.name, is_admin=user.is_admin, scopes=frozenset(scopes))


def _token_hash(text: str) -> str:
    # Not argon2: a token has 256 random bits, nobody can try them all.
    return hashlib.sha256(text.encode()).hexdigest()


def _check_password(password: str) -> None:
    if not PASSWORD_MIN <= len(password) <= PASSWORD_MAX:
        raise AccountRejected(f"A password has {PASSWORD_MIN} to {PASSWORD_MAX} characters.")
