"""The tables of what happens to accounts: passwords by a link, linked identities, deletions."""

from sqlalchemy import ForeignKey, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


class PasswordReset(Base):
    """A link by which one account gets a new password; only its SHA-256 is stored."""

    __tablename__ = "password_resets"

    hash: Mapped[str] = mapped_column(String(64), primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    expires_at: Mapped[float]


class AccountDeletion(Base):
    """An account that was closed and whose private runs are being deleted."""

    __tablename__ = "account_deletions"

    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    requested_at: Mapped[float]


class LinkedIdentity(Base):
    """Whoever an identity provider recognises as this subject signs in to the account."""

    __tablename__ = "linked_identities"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    issuer: Mapped[str] = mapped_column(String(300))
    subject: Mapped[str] = mapped_column(String(255))
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"))
    label: Mapped[str] = mapped_column(String(120))  # what the provider called them
    linked_at: Mapped[float]

    __table_args__ = (
        UniqueConstraint("issuer", "subject"),
        UniqueConstraint("user_id", "issuer"),
    )
