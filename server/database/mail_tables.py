"""The tables of e-mail: addresses of accounts, what is to be sent, and runs to tell about."""

from sqlalchemy import ForeignKey, Index, String, text
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId


class MailAddress(Base):
    """The address of an account, and the one that is to replace it once it is confirmed."""

    __tablename__ = "mail_addresses"

    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    address: Mapped[str | None] = mapped_column(String(254))  # confirmed
    address_hash: Mapped[str | None] = mapped_column(String(64), index=True)
    pending: Mapped[str | None] = mapped_column(String(254))  # not yet confirmed
    pending_hash: Mapped[str | None] = mapped_column(String(64), unique=True)  # of its link
    pending_until: Mapped[float | None]


class OutgoingMail(Base):
    """An e-mail to be sent, without its text: what it says is found when it is sent.

    So no copy of the database has a link that works. The row stays for a while, to be counted.
    """

    __tablename__ = "outgoing_mails"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    kind: Mapped[str] = mapped_column(String(20))
    user_id: Mapped[int | None] = mapped_column(  # NULL: whoever has the address
        ForeignKey("users.id", ondelete="SET NULL"), index=True
    )
    address_hash: Mapped[str] = mapped_column(String(64))  # who gets it, for finding and counting
    created_at: Mapped[float]
    next_try_at: Mapped[float]
    tries: Mapped[int] = mapped_column(default=0)
    ended_at: Mapped[float | None]

    __table_args__ = (
        Index("ix_outgoing_mails_address_hash_created", "address_hash", "created_at"),
        Index(
            "ix_outgoing_mails_due",
            "next_try_at",
            sqlite_where=text("ended_at IS NULL"),
            postgresql_where=text("ended_at IS NULL"),
        ),
        {"sqlite_autoincrement": True},
    )


class RunNotice(Base):
    """A run that has ended and about which its owner wants an e-mail."""

    __tablename__ = "run_notices"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    user_id: Mapped[int] = mapped_column(ForeignKey("users.id", ondelete="CASCADE"), index=True)
    run_id: Mapped[int] = mapped_column(ForeignKey("runs.id", ondelete="CASCADE"), index=True)

    __table_args__ = ({"sqlite_autoincrement": True},)
