"""Leaderboards with one row for each method.

Revision ID: 0037
Revises: 0036
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0037"
down_revision = "0036"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_COPIED = (
    "benchmark, user_id, run_id, score, score_low, score_high, standard_error, degrees, "
    "is_baseline, level_held, submissions, reached_at, language, vehicle, tracker"
)
# A row without metrics is computed anew by the workers, with all others of its user.
_FILL = f"""
    INSERT INTO best_methods ({_COPIED}, method, metrics)
    SELECT
        {", ".join(f"best.{name}" for name in _COPIED.split(", "))},
        CASE WHEN best.is_baseline THEN '' ELSE LOWER(runs.method) END,
        CASE WHEN best.is_baseline OR 1 = (
            SELECT COUNT(DISTINCT other.method) FROM runs AS other
            WHERE other.user_id = best.user_id AND other.benchmark = best.benchmark
              AND other.kind = 'ranked' AND other.public
        ) THEN best.metrics END
    FROM best JOIN runs ON runs.id = best.run_id
"""


def upgrade() -> None:
    """Add the table, with the best method of everybody; workers add those of people with others."""
    op.create_table(
        "best_methods",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("method", sa.String(180), nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        sa.Column("score", sa.Double(), nullable=False),
        sa.Column("score_low", sa.Double(), nullable=False),
        sa.Column("score_high", sa.Double(), nullable=False),
        sa.Column("standard_error", sa.Double()),
        sa.Column("degrees", sa.Integer(), server_default="0", nullable=False),
        sa.Column("is_baseline", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("level_held", sa.Double()),
        sa.Column("submissions", sa.Integer(), server_default="1", nullable=False),
        sa.Column("reached_at", sa.Double(), nullable=False),
        sa.Column("language", sa.String(40), server_default="", nullable=False),
        sa.Column("vehicle", sa.String(40), server_default="", nullable=False),
        sa.Column("tracker", sa.String(40), server_default="", nullable=False),
        sa.Column("metrics", sa.JSON()),
        sa.CheckConstraint("score > -1e300 AND score < 1e300", name=op.f("ck_best_methods_finite")),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_best_methods_run_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_best_methods_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("benchmark", "user_id", "method", name="pk_best_methods"),
        sa.UniqueConstraint("run_id", name="uq_best_methods_run_id"),
    )
    op.create_index(
        "ix_best_methods_rank",
        "best_methods",
        ["benchmark", sa.text("score DESC"), "reached_at", "run_id", "is_baseline"],
    )
    op.create_index(
        "ix_best_methods_baselines", "best_methods", ["benchmark"], **_where("is_baseline")
    )
    op.create_index(
        "ix_best_methods_without_metrics", "best_methods", ["run_id"], **_where("metrics IS NULL")
    )
    methods = sa.Column("methods", sa.Integer(), server_default="0", nullable=False)
    op.add_column("score_counts", methods)
    op.execute(_FILL)
    op.execute("UPDATE score_counts SET methods = people")


def downgrade() -> None:
    """Leaderboards have one row for each person again."""
    op.drop_column("score_counts", "methods")
    op.drop_table("best_methods")


def _where(condition: str) -> dict[str, Any]:
    return dict.fromkeys(("sqlite_where", "postgresql_where"), sa.text(condition))
