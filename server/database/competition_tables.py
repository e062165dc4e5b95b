"""The tables of competitions: what is asked, rounds, teams, and what they submitted."""

from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    CheckConstraint,
    ForeignKey,
    Index,
    LargeBinary,
    String,
    Text,
    UniqueConstraint,
    false,
)
from sqlalchemy.orm import Mapped, mapped_column

from seamark.server.database.tables import Base, RowId

_Json = JSON(none_as_null=True)


class Competition(Base):
    """An organiser's benchmark with its rounds. What is asked is frozen when it opens."""

    __tablename__ = "competitions"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    name: Mapped[str] = mapped_column(String(60), unique=True)  # with its version: harbour-cup-v1
    organiser_id: Mapped[int | None] = mapped_column(  # NULL: the account was deleted
        ForeignKey("users.id", ondelete="SET NULL"), index=True
    )
    document: Mapped[dict[str, Any]] = mapped_column(
        _Json
    )  # as seamark.competitions.document reads
    digest: Mapped[str] = mapped_column(String(64))  # SHA-256 of the document
    picture: Mapped[bytes | None] = mapped_column(LargeBinary, deferred=True)  # PNG or JPEG
    vehicle_sha256: Mapped[str | None] = mapped_column(String(64), index=True)
    created_at: Mapped[float]
    opened_at: Mapped[float | None]  # NULL: a draft
    ended_at: Mapped[float | None]  # all of its rounds are decided

    __table_args__ = ({"sqlite_autoincrement": True},)


class CompetitionFile(Base):
    """A file that a setting of a competition names, as `RunFile` of a run."""

    __tablename__ = "competition_files"

    competition_id: Mapped[int] = mapped_column(
        ForeignKey("competitions.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    setting: Mapped[str] = mapped_column(String(40), primary_key=True)
    sha256: Mapped[str] = mapped_column(String(64), index=True)


class Round(Base):
    """A round of a competition; number 0 is the check of a draft by its reference entries."""

    __tablename__ = "competition_rounds"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    competition_id: Mapped[int] = mapped_column(ForeignKey("competitions.id", ondelete="CASCADE"))
    number: Mapped[int]
    kind: Mapped[str] = mapped_column(String(15))
    opens_at: Mapped[float]
    closes_at: Mapped[float | None]  # of the submission, not of its result; NULL: a final
    commitment: Mapped[str] = mapped_column(String(64))  # SHA-256 of the key
    key: Mapped[str | None] = mapped_column(String(64))  # hexadecimal; NULL: not revealed yet
    batches: Mapped[int] = mapped_column(default=0, server_default="0")  # of a final, submitted
    decided_at: Mapped[float | None]

    __table_args__ = (
        CheckConstraint("kind IN ('check', 'practice', 'qualification', 'final')", name="kind"),
        UniqueConstraint("competition_id", "number"),
        Index("ix_competition_rounds_undecided", "decided_at", "opens_at"),
        {"sqlite_autoincrement": True},
    )


class RoundChange(Base):
    """That an organiser moved the times of a round: everybody sees it."""

    __tablename__ = "round_changes"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    round_id: Mapped[int] = mapped_column(
        ForeignKey("competition_rounds.id", ondelete="CASCADE"), index=True
    )
    at: Mapped[float]
    before: Mapped[float]
    after: Mapped[float]
    reason: Mapped[str] = mapped_column(String(300))


class Team(Base):
    """Who takes part in a competition: one person or several."""

    __tablename__ = "teams"

    id: Mapped[int] = mapped_column(RowId, primary_key=True)
    competition_id: Mapped[int] = mapped_column(ForeignKey("competitions.id", ondelete="CASCADE"))
    name: Mapped[str] = mapped_column(String(60))
    name_key: Mapped[str] = mapped_column(String(120))  # case-folded
    code: Mapped[str] = mapped_column(String(16), unique=True)  # whoever knows it may join
    captain_id: Mapped[int | None] = mapped_column(  # NULL: everybody has left
        ForeignKey("users.id", ondelete="SET NULL"), index=True
    )
    created_at: Mapped[float]

    __table_args__ = (
        UniqueConstraint("competition_id", "name_key"),
        {"sqlite_autoincrement": True},  # ids stand in owners of runs: never reused
    )


class TeamMember(Base):
    """A member of a team; in each competition a person is in one team at most."""

    __tablename__ = "team_members"

    competition_id: Mapped[int] = mapped_column(
        ForeignKey("competitions.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    user_id: Mapped[int] = mapped_column(
        ForeignKey("users.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    team_id: Mapped[int] = mapped_column(ForeignKey("teams.id", ondelete="CASCADE"), index=True)
    joined_at: Mapped[float]  # when the rules were agreed on

    __table_args__ = (Index("ix_team_members_user_id", "user_id"),)


class MethodText(Base):
    """How a team describes one of its methods."""

    __tablename__ = "method_texts"

    team_id: Mapped[int] = mapped_column(
        ForeignKey("teams.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    method_key: Mapped[str] = mapped_column(String(120), primary_key=True)  # case-folded
    text: Mapped[str] = mapped_column(Text)


class Entry(Base):
    """A run that counts in a round: of a team, or a reference entry of the service.

    The run of a final evaluates what was submitted to an earlier round. The result is repeated
    here so that a board is read from this table alone.
    """

    __tablename__ = "entries"

    run_id: Mapped[int] = mapped_column(
        ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True, autoincrement=False
    )
    round_id: Mapped[int] = mapped_column(ForeignKey("competition_rounds.id", ondelete="CASCADE"))
    team_id: Mapped[int | None] = mapped_column(  # NULL: a reference entry
        ForeignKey("teams.id", ondelete="CASCADE"), index=True
    )
    user_id: Mapped[int | None] = mapped_column(  # who submitted it
        ForeignKey("users.id", ondelete="SET NULL"), index=True
    )
    method: Mapped[str] = mapped_column(String(60))
    method_key: Mapped[str] = mapped_column(String(120))  # case-folded
    reference: Mapped[str] = mapped_column(String(40), default="", server_default="")  # its name
    carried: Mapped[int | None] = mapped_column(BigInteger)  # in a final: the run of the entry
    batch: Mapped[int] = mapped_column(default=0, server_default="0")  # of a final, from 1
    submitted_at: Mapped[float]  # in a final: of the entry that was carried into it
    chosen: Mapped[bool] = mapped_column(default=False, server_default=false())  # for the final
    withdrawn_at: Mapped[float | None]
    refusal: Mapped[str | None] = mapped_column(Text)  # why it has no score: a sentence
    score: Mapped[float | None]
    score_low: Mapped[float | None]
    score_high: Mapped[float | None]
    standard_error: Mapped[float | None]
    degrees: Mapped[int] = mapped_column(default=0, server_default="0")
    scores: Mapped[list[float] | None] = mapped_column(_Json, deferred=True)  # one for each trial

    __table_args__ = (
        Index("ix_entries_round_id_team_id", "round_id", "team_id", "method_key", "score"),
        Index("ix_entries_round_id_batch", "round_id", "batch"),
    )


class FinalPlace(Base):
    """The place of a method when its competition is decided; rows are never changed."""

    __tablename__ = "final_places"

    round_id: Mapped[int] = mapped_column(
        ForeignKey("competition_rounds.id", ondelete="CASCADE"),
        primary_key=True,
        autoincrement=False,
    )
    run_id: Mapped[int] = mapped_column(  # of the first batch, or of the entry if there is no final
        BigInteger, primary_key=True, autoincrement=False
    )
    team_id: Mapped[int | None] = mapped_column(  # NULL: a reference entry, which has no place
        ForeignKey("teams.id", ondelete="CASCADE"), index=True
    )
    method: Mapped[str] = mapped_column(String(60))
    place: Mapped[int | None]  # NULL: it failed, or is a reference entry
    place_low: Mapped[int | None]
    place_high: Mapped[int | None]
    score: Mapped[float | None]
    score_low: Mapped[float | None]
    score_high: Mapped[float | None]
    trials: Mapped[int]
    refusal: Mapped[str | None] = mapped_column(Text)
