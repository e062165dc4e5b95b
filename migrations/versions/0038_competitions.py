"""Competitions: an organiser's benchmark, its rounds, teams and their entries.

Revision ID: 0038
Revises: 0037
"""

import sqlalchemy as sa
from alembic import op

revision = "0038"
down_revision = "0037"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """Add the tables; there is no competition yet."""
    op.create_table(
        "competitions",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("name", sa.String(length=60), nullable=False),
        sa.Column("organiser_id", _ROW_ID),
        sa.Column("document", sa.JSON(none_as_null=True), nullable=False),
        sa.Column("digest", sa.String(length=64), nullable=False),
        sa.Column("picture", sa.LargeBinary()),
        sa.Column("vehicle_sha256", sa.String(length=64)),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("opened_at", sa.Double()),
        sa.Column("ended_at", sa.Double()),
        sa.ForeignKeyConstraint(
            ["organiser_id"], ["users.id"], name="fk_competitions_organiser_id", ondelete="SET NULL"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_competitions"),
        sa.UniqueConstraint("name", name="uq_competitions_name"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_competitions_organiser_id", "competitions", ["organiser_id"])
    op.create_index(
        "ix_competitions_vehicle_sha256", "competitions", ["vehicle_sha256"], unique=False
    )
    op.create_table(
        "competition_rounds",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("competition_id", _ROW_ID, nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("kind", sa.String(length=15), nullable=False),
        sa.Column("opens_at", sa.Double(), nullable=False),
        sa.Column("closes_at", sa.Double()),
        sa.Column("commitment", sa.String(length=64), nullable=False),
        sa.Column("key", sa.String(length=64)),
        sa.Column("batches", sa.Integer(), server_default="0", nullable=False),
        sa.Column("decided_at", sa.Double()),
        sa.CheckConstraint(
            "kind IN ('check', 'practice', 'qualification', 'final')",
            name="ck_competition_rounds_kind",
        ),
        sa.ForeignKeyConstraint(
            ["competition_id"],
            ["competitions.id"],
            name="fk_competition_rounds_competition_id",
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name="pk_competition_rounds"),
        sa.UniqueConstraint(
            "competition_id", "number", name="uq_competition_rounds_competition_id_number"
        ),
        sqlite_autoincrement=True,
    )
    op.create_index(
        "ix_competition_rounds_undecided",
        "competition_rounds",
        ["decided_at", "opens_at"],
    )
    op.create_table(
        "teams",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("competition_id", _ROW_ID, nullable=False),
        sa.Column("name", sa.String(length=60), nullable=False),
        sa.Column("name_key", sa.String(length=120), nullable=False),
        sa.Column("code", sa.String(length=16), nullable=False),
        sa.Column("captain_id", _ROW_ID),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["captain_id"], ["users.id"], name="fk_teams_captain_id", ondelete="SET NULL"
        ),
        sa.ForeignKeyConstraint(
            ["competition_id"],
            ["competitions.id"],
            name="fk_teams_competition_id",
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name="pk_teams"),
        sa.UniqueConstraint("code", name="uq_teams_code"),
        sa.UniqueConstraint("competition_id", "name_key", name="uq_teams_competition_id_name_key"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_teams_captain_id", "teams", ["captain_id"])
    op.create_table(
        "method_texts",
        sa.Column("team_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("method_key", sa.String(length=120), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(
            ["team_id"], ["teams.id"], name="fk_method_texts_team_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("team_id", "method_key", name="pk_method_texts"),
    )
    op.create_table(
        "entries",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("round_id", _ROW_ID, nullable=False),
        sa.Column("team_id", _ROW_ID),
        sa.Column("user_id", _ROW_ID),
        sa.Column("method", sa.String(length=60), nullable=False),
        sa.Column("method_key", sa.String(length=120), nullable=False),
        sa.Column("reference", sa.String(length=40), server_default="", nullable=False),
        sa.Column("carried", sa.BigInteger()),
        sa.Column("batch", sa.Integer(), server_default="0", nullable=False),
        sa.Column("submitted_at", sa.Double(), nullable=False),
        sa.Column("chosen", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("withdrawn_at", sa.Double()),
        sa.Column("refusal", sa.Text()),
        sa.Column("score", sa.Double()),
        sa.Column("score_low", sa.Double()),
        sa.Column("score_high", sa.Double()),
        sa.Column("standard_error", sa.Double()),
        sa.Column("degrees", sa.Integer(), server_default="0", nullable=False),
        sa.Column("scores", sa.JSON(none_as_null=True)),
        sa.ForeignKeyConstraint(
            ["round_id"], ["competition_rounds.id"], name="fk_entries_round_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_entries_run_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["team_id"], ["teams.id"], name="fk_entries_team_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_entries_user_id", ondelete="SET NULL"
        ),
        sa.PrimaryKeyConstraint("run_id", name="pk_entries"),
    )
    op.create_index(
        "ix_entries_round_id_batch", "entries", ["round_id", "batch"], unique=False
    )
    op.create_index(
        "ix_entries_round_id_team_id",
        "entries",
        ["round_id", "team_id", "method_key", "score"],
    )
    op.create_index("ix_entries_team_id", "entries", ["team_id"])
    op.create_index("ix_entries_user_id", "entries", ["user_id"])
    op.create_table(
        "final_places",
        sa.Column("round_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("run_id", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("team_id", _ROW_ID),
        sa.Column("method", sa.String(length=60), nullable=False),
        sa.Column("place", sa.Integer()),
        sa.Column("place_low", sa.Integer()),
        sa.Column("place_high", sa.Integer()),
        sa.Column("score", sa.Double()),
        sa.Column("score_low", sa.Double()),
        sa.Column("score_high", sa.Double()),
        sa.Column("trials", sa.Integer(), nullable=False),
        sa.Column("refusal", sa.Text()),
        sa.ForeignKeyConstraint(
            ["round_id"],
            ["competition_rounds.id"],
            name="fk_final_places_round_id",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["team_id"], ["teams.id"], name="fk_final_places_team_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("round_id", "run_id", name="pk_final_places"),
    )
    op.create_index("ix_final_places_team_id", "final_places", ["team_id"])
    op.create_table(
        "round_changes",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("round_id", _ROW_ID, nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("before", sa.Double(), nullable=False),
        sa.Column("after", sa.Double(), nullable=False),
        sa.Column("reason", sa.String(length=300), nullable=False),
        sa.ForeignKeyConstraint(
            ["round_id"],
            ["competition_rounds.id"],
            name="fk_round_changes_round_id",
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name="pk_round_changes"),
    )
    op.create_index("ix_round_changes_round_id", "round_changes", ["round_id"])
    op.create_table(
        "team_members",
        sa.Column("competition_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("team_id", _ROW_ID, nullable=False),
        sa.Column("joined_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["competition_id"],
            ["competitions.id"],
            name="fk_team_members_competition_id",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["team_id"], ["teams.id"], name="fk_team_members_team_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_team_members_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("competition_id", "user_id", name="pk_team_members"),
    )
    op.create_index("ix_team_members_team_id", "team_members", ["team_id"])
    op.create_index("ix_team_members_user_id", "team_members", ["user_id"])


def downgrade() -> None:
    """Forget all competitions; the runs of their entries stay, as those of nobody."""
    op.drop_table("team_members")
    op.drop_table("round_changes")
    op.drop_table("final_places")
    op.drop_table("entries")
    op.drop_table("method_texts")
    op.drop_table("teams")
    op.drop_table("competition_rounds")
    op.drop_table("competitions")
