"""The tables of what happens to accounts: new passwords by a link, and deletions."""

from sqlalchemy import ForeignKey, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base


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
