"""Terms of publications, addresses that outlive them, and verifications in fresh water."""

import sqlalchemy as sa
from alembic import op

revision = "0029"
down_revision = "0028"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """What is public so far is named and has its program, without a licence."""
    no, yes = sa.false(), sa.true()
    for column in (
        sa.Column("anonymous", sa.Boolean(), server_default=no, nullable=False),
        sa.Column("program_public", sa.Boolean(), server_default=yes, nullable=False),
        sa.Column("licence", sa.String(40), nullable=True),
        sa.Column("draw", sa.Integer(), nullable=True),
    ):
        op.add_column("runs", column)
    _index_ranks("run_id")
    op.create_table(
        "publications",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("first_at", sa.Double(), nullable=False),
        sa.Column("withdrawn_at", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("run_id", name=op.f("pk_publications")),
    )
    op.execute(
        "INSERT INTO publications (run_id, first_at) "
        "SELECT id, COALESCE(published_at, finished_at, queued_at) FROM runs WHERE public"
    )
    _create_verifications()


def downgrade() -> None:
    """Runs that are anonymous or without their program become private: they would show both."""
    hidden = "SELECT id FROM runs WHERE owner = 'rejudgement:verifications'"
    op.execute(f"DELETE FROM results WHERE run_id IN ({hidden})")
    op.drop_table("verifications")
    op.execute("DELETE FROM runs WHERE owner = 'rejudgement:verifications'")
    op.execute("DELETE FROM turns WHERE owner = 'rejudgement:verifications'")
    op.drop_table("publications")
    shown = "anonymous OR NOT program_public"
    op.execute(f"DELETE FROM best WHERE run_id IN (SELECT id FROM runs WHERE {shown})")
    public, private = "public AND (" + shown + ")", "public = false, published_at = NULL"
    op.execute(f"UPDATE runs SET {private} WHERE {public}")
    _index_ranks("user_id")
    for name in ("draw", "licence", "program_public", "anonymous"):
        op.drop_column("runs", name)


def _index_ranks(last: str) -> None:
    op.drop_index("ix_best_rank", "best")
    columns: list[str | sa.TextClause] = ["benchmark", sa.text("score DESC"), "reached_at", last, "is_baseline"]
    op.create_index("ix_best_rank", "best", columns)


def _create_verifications() -> None:
    op.create_table(
        "verifications",
        sa.Column("again_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        sa.Column("requested_at", sa.Double(), nullable=False),
        sa.Column("ended_at", sa.Double(), nullable=True),
        sa.Column("version", sa.String(40), nullable=True),
        sa.Column("digest", sa.String(64), nullable=True),
        sa.Column("cause", sa.String(20), nullable=True),
        *(
            sa.Column(name, sa.Double(), nullable=True)
            for name in ("score", "score_low", "score_high", "standard_error")
        ),
        sa.Column("degrees", sa.Integer(), server_default="0", nullable=False),
        sa.PrimaryKeyConstraint("again_id", name=op.f("pk_verifications")),
        *(
            sa.ForeignKeyConstraint(
                [column],
                ["runs.id"],
                name=op.f(f"fk_verifications_{column}"),
                ondelete="CASCADE",
            )
            for column in ("again_id", "run_id")
        ),
    )
    op.create_index("ix_verifications_run_id", "verifications", ["run_id", "again_id"])
