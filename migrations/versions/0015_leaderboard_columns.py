"""What leaderboards filter and sort by, the history of ranks, and the profiles of users."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

PROFILE = {"public_name": 80, "affiliation": 120, "paper_url": 300, "code_url": 300}
COPIED = ("language", "vehicle", "tracker")
FILL = {
    "sqlite": """
        UPDATE best SET language = coalesce(r.language, ''),
            vehicle = substr(coalesce(json_extract(r.config, '$.vehicle'), ''), 1, 40),
            tracker = CASE
                WHEN r.benchmark LIKE 'visibility%' AND r.controller <> 'built-in' THEN ''
                ELSE substr(coalesce(json_extract(r.config, '$.tracker'), ''), 1, 40)
            END
        FROM runs AS r WHERE r.id = best.run_id
    """,
    "postgresql": """
        UPDATE best SET language = coalesce(r.language, ''),
            vehicle = substr(coalesce(r.config ->> 'vehicle', ''), 1, 40),
            tracker = CASE
                WHEN r.benchmark LIKE 'visibility%' AND r.controller <> 'built-in' THEN ''
                ELSE substr(coalesce(r.config ->> 'tracker', ''), 1, 40)
            END
        FROM runs AS r WHERE r.id = best.run_id
    """,
}


def upgrade() -> None:
    """The maintenance process computes the metrics of earlier rows."""
    for name, length in PROFILE.items():
        op.add_column(
            "users", sa.Column(name, sa.String(length), nullable=False, server_default="")
        )
    for name in COPIED:
        op.add_column("best", sa.Column(name, sa.String(40), nullable=False, server_default=""))
    op.add_column("best", sa.Column("metrics", sa.JSON(none_as_null=True), nullable=True))
    missing = sa.text("metrics IS NULL")
    op.create_index(
        "ix_best_without_metrics",
        "best",
        ["run_id"],
        sqlite_where=missing,
        postgresql_where=missing,
    )
    op.execute(FILL[op.get_bind().dialect.name])
    key = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "rank_points",
        sa.Column("id", key, nullable=False),
        sa.Column("user_id", key, nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("rank", sa.Integer(), nullable=True),
        sa.Column("people", sa.Integer(), nullable=False),
        sa.Column("score", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["user_id"],
            ["users.id"],
            name=op.f("fk_rank_points_user_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_rank_points")),
    )
    op.create_index(
        "ix_rank_points_user_benchmark_id", "rank_points", ["user_id", "benchmark", "id"]
    )


def downgrade() -> None:
    """Drop the table and the columns."""
    op.drop_table("rank_points")
    op.drop_index("ix_best_without_metrics", "best")
    for name in ("metrics", *COPIED):
        op.drop_column("best", name)
    for name in PROFILE:
        op.drop_column("users", name)
