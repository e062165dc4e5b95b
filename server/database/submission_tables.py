"""The table of the keys by which repeated submissions are recognised."""

from sqlalchemy import BigInteger, ForeignKey, Index, String
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base


class KeyOfSubmission(Base):
    """What a submission with an Idempotency-Key has started."""

    __tablename__ = "submission_keys"

    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    key: Mapped[str] = mapped_column(String(64), primary_key=True)  # SHA-256
    request: Mapped[str] = mapped_column(String(64))  # SHA-256 of what was submitted
    number: Mapped[int] = mapped_column(BigInteger)  # of the run or the sweep
    created_at: Mapped[float]

    __table_args__ = (Index("ix_submission_keys_user_id_created_at", "user_id", "created_at"),)
