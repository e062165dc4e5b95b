"""Accounts, passwords and tokens."""

import contextlib
import hashlib
import hmac
import math
import re
import secrets
import time
from base64 import b64encode
from collections.abc import Iterable
from typing import Any

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import ARGON2_VERSION
from sqlalchemy import Row, bindparam, delete, func, select, update
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.accounts.permissions import (
    SCOPES,
    Role,
    Viewer,
    grantable,
)
from seamark.server.database.engine import Database
from seamark.server.database.tables import BrowserSession, Token, User
from seamark.server.settings import Settings

NAME_MAX = 40  # [character]
NAME_RULE = f"2 to {NAME_MAX} letters, digits, dots, dashes or underscores, starting with a letter"
RESERVED = frozenset({"guest"})  # the name shown for runs without an account
RESERVED_PREFIX = "seamark"  # the owners of the baselines
PASSWORD_MIN, PASSWORD_MAX = 10, 200
TOKEN_PREFIX = "smk_"  # noqa: S105 - lets secret scanners recognise our tokens
TOKEN_DAYS, TOKEN_DAYS_MAX = 90, 3650
PAGE_TOKEN_DAYS_MAX = 365  # whoever needs a longer one asks for it by the API
TOKENS_MAX = 50  # per account
TOKEN_NAME_MAX = 80  # [character]
_NAME = re.compile(rf"[A-Za-z][A-Za-z0-9._-]{{1,{NAME_MAX - 1}}}")
_DAY_S = 86_400.0
_USED_STEP_S = 600.0  # `last_used_at` is written at most this often
_hasher = PasswordHasher()


def _hash_of_no_password(hasher: PasswordHasher) -> str:
    """Return a drawn hash, which costs as much to verify as those of `hasher`, and nothing to make.

    Verified for unknown names, so that the response time does not reveal which names exist.
    """
    costs = f"m={hasher.memory_cost},t={hasher.time_cost},p={hasher.parallelism}"
    drawn = map(secrets.token_bytes, (hasher.salt_len, hasher.hash_len))
    salt, digest = (b64encode(one).rstrip(b"=").decode() for one in drawn)
    return f"$argon2id$v={ARGON2_VERSION}${costs}${salt}${digest}"


class AccountRejected(Exception):
    """The account cannot be created or changed. The text is for the user."""


def sign_up(session: Session, name: str, password: str | None, *, role: Role = Role.USER) -> User:
    """Create an account; raises AccountRejected. Without a password, nobody can sign in to it."""
    if not _NAME.fullmatch(name):
        raise AccountRejected(f"A name consists of {NAME_RULE}.")
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
        role=role.label,
        created_at=time.time(),
    )
    session.add(user)
    session.flush()
    return user


def authenticate(session: Session, name: str, password: str) -> User | None:
    """Return the user if the password is correct; takes equally long for unknown names."""
    user = session.scalar(select(User).where(User.name_key == name.casefold()))
    password_hash = user.password_hash if user is not None else None
    try:
        known = password_hash or _hash_of_no_password(_hasher)
        _hasher.verify(known, password[: PASSWORD_MAX + 1])
    except (VerificationError, InvalidHashError):
        return None
    return user if password_hash else None


def change_password(session: Session, name: str, new: str) -> User:
    """Set a new password and return the user; signs out all browsers and revokes all tokens.

    Raises
    ------
    AccountRejected
        There is no such account, or the password breaks a rule.
    """
    user = person(session, name)
    _check_password(new)
    user.password_hash = _hasher.hash(new)
    # Whoever changes it may do so because somebody else knows the old one.
    revoke_access(session, user.id)
    return user


def revoke_access(session: Session, user_id: int) -> None:
    """Sign out all browsers of an account and revoke all its tokens."""
    session.execute(delete(BrowserSession).where(BrowserSession.user_id == user_id))
    session.execute(delete(Token).where(Token.user_id == user_id))


def person(session: Session, name: str) -> User:
    """Return the account of a person; raises AccountRejected if there is none with this name."""
    user = session.scalar(select(User).where(User.name_key == name.casefold()))
    if user is None or user.is_baseline:
        raise AccountRejected(f"There is no account {name}.")
    return user


def people(session: Session) -> list[User]:
    """Return the accounts of people, oldest first."""
    return list(session.scalars(select(User).where(~User.is_baseline).order_by(User.id)))


def guest_hash(settings: Settings, cookie: str) -> str:
    """Return the keyed hash of a guest's cookie, under which the guest's runs are stored."""
    return hmac.new(settings.secret_key.encode(), f"guest {cookie}".encode(), "sha256").hexdigest()


def new_token(
    session: Session, user_id: int, name: str, scopes: Iterable[str], *, days: float = TOKEN_DAYS
) -> str:
    """Create a token and return its text, which is not stored and cannot be shown again.

    Raises
    ------
    AccountRejected
        A scope is unknown, there is none, or the user has too many tokens.
    """
    granted = sorted(set(scopes))
    if unknown := set(granted) - set(SCOPES):
        raise AccountRejected(f"Unknown scope: {', '.join(sorted(unknown))}.")
    if not granted:
        raise AccountRejected("A token needs at least one scope.")
    count = select(func.count()).where(Token.user_id == user_id)
    if (session.scalar(count) or 0) >= TOKENS_MAX:
        raise AccountRejected(f"You already have {TOKENS_MAX} tokens. Revoke one first.")
    text = TOKEN_PREFIX + secrets.token_urlsafe(32)
    now = time.time()
    token = Token(
        user_id=user_id,
        name=visible_text(name).strip()[:TOKEN_NAME_MAX] or "token",
        hash=secret_hash(text),
        scopes=granted,
        created_at=now,
        expires_at=now + days * _DAY_S,
    )
    session.add(token)
    session.flush()
    return text


def grant_token(
    session: Session, viewer: Viewer, name: str, scopes: Iterable[str], *, days: float
) -> str:
    """Create a token for the viewer as `new_token`, which grants nothing the viewer lacks.

    A token cannot grant scopes that it does not have, nor outlive itself by a new one.
    """
    if viewer.user_id is None:
        raise AccountRejected("Tokens need an account.")
    if beyond := set(scopes) - set(grantable(viewer)):
        raise AccountRejected(f"You cannot grant: {', '.join(sorted(beyond))}.")
    if viewer.token_expires_at is not None:
        days = min(days, (viewer.token_expires_at - time.time()) / _DAY_S)
    return new_token(session, viewer.user_id, name, scopes, days=days)


def tokens(session: Session, user_id: int) -> list[Token]:
    """Return a user's tokens, newest first."""
    query = select(Token).where(Token.user_id == user_id).order_by(Token.id.desc())
    return list(session.scalars(query))


def revoke_token(session: Session, user_id: int, token_id: int) -> bool:
    """Delete one of the user's tokens; False if there is no such token."""
    deletion = delete(Token).where(Token.id == token_id, Token.user_id == user_id)
    return session.scalar(deletion.returning(Token.id)) is not None


def viewer_of_token(session: Session, text: str) -> Viewer | None:
    """Return the viewer of a token; None if it is unknown or expired, or the account disabled."""
    row = _valid_token(session, text)
    return None if row is None else _viewer_by(row)


def use_token(database: Database, text: str) -> Viewer | None:
    """Do as `viewer_of_token`, and record that the token was used.

    A database that cannot be written to for now records nothing: what is only read can be read.
    """
    with database.reading() as session:
        row = _valid_token(session, text)
    if row is None:
        return None
    now = time.time()
    if (row.last_used_at or 0.0) < now - _USED_STEP_S:
        unrecorded = Token.last_used_at.is_(None) | (Token.last_used_at < now - _USED_STEP_S)
        used = update(Token).where(Token.id == row.id, unrecorded).values(last_used_at=now)
        with contextlib.suppress(OperationalError), database.writing() as session:
            session.execute(used)
    return _viewer_by(row)


# Almost every request asks for it, or for that of a browser: to make it takes as long as to ask.
_BY_HASH = (
    select(
        *(Token.id, Token.scopes, Token.expires_at, Token.last_used_at),
        *(User.id.label("user_id"), User.name, User.role, User.disabled_at),
    )
    .join(User, User.id == Token.user_id)
    .where(Token.hash == bindparam("hash"))
)


def _valid_token(session: Session, text: str) -> Row[*tuple[Any, ...]] | None:
    row = session.execute(_BY_HASH, {"hash": secret_hash(text)}).one_or_none()
    if row is None:
        return None
    expired = row.expires_at is not None and row.expires_at <= time.time()
    return None if expired or row.disabled_at is not None else row


def _viewer_by(row: Row[*tuple[Any, ...]]) -> Viewer:
    expires_at = math.inf if row.expires_at is None else row.expires_at
    return viewer_of_account(
        row.user_id, row.name, row.role, row.scopes, token_expires_at=expires_at
    )


def viewer_of_account(
    user_id: int,
    name: str,
    role: str,
    scopes: Iterable[str],
    *,
    token_expires_at: float | None = None,
) -> Viewer:
    """Return the viewer of an account with some scopes."""
    return Viewer(
        user_id=user_id,
        name=name,
        account_role=Role[role.upper()],
        scopes=frozenset(scopes),
        token_expires_at=token_expires_at,
    )


def secret_hash(text: str) -> str:
    """Return the hash under which a drawn secret is stored: a token, session or invitation."""
    # Not argon2: it has at least 144 random bits and cannot be guessed.
    return hashlib.sha256(text.encode()).hexdigest()


def _check_password(password: str) -> None:
    if not PASSWORD_MIN <= len(password) <= PASSWORD_MAX:
        raise AccountRejected(f"A password has {PASSWORD_MIN} to {PASSWORD_MAX} characters.")
