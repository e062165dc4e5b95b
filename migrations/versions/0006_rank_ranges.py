"""Rows of the leaderboard know the error of their score; people are counted by classes of scores."""

import math
from collections import Counter

import sqlalchemy as sa
from alembic import op


revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None

# The intervals so far were 95 % percentile bootstrap intervals, of 10 trials if nobody changed the
# default: 2 * 1.96 * sqrt(9 / 10) standard errors wide. A single trial has no interval.
_ERRORS = """
    UPDATE best SET
        standard_error = (score_high - score_low) / 3.7188,
        degrees = (SELECT runs.trials - 1 FROM runs WHERE runs.id = best.run_id)
    WHERE score_high > score_low
"""
_BASELINES = """
    UPDATE best SET is_baseline = (SELECT users.is_baseline FROM users WHERE users.id = best.user_id)
"""
_RANK = ("benchmark", sa.text("score DESC"), "reached_at", "user_id")
_PEOPLE = "SELECT benchmark, score, standard_error, degrees FROM best WHERE NOT is_baseline"


def upgrade() -> None:
    """`seamark db rebuild-leaderboard` computes the errors from the trials' scores instead."""
    op.add_column("best", sa.Column("standard_error", sa.Double(), nullable=True))
    op.add_column("best", sa.Column("degrees", sa.Integer(), nullable=False, server_default="0"))
    op.add_column(
        "best", sa.Column("is_baseline", sa.Boolean(), nullable=False, server_default=sa.false())
    )
    op.execute(_ERRORS)
    op.execute(_BASELINES)
    op.drop_index("ix_best_rank", table_name="best")
    op.create_index("ix_best_rank", "best", [*_RANK, "is_baseline"])
    counts = op.create_table(
        "score_counts",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("score_class", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("error_class", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("degrees", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("people", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint(
            "benchmark", "score_class", "error_class", "degrees", name=op.f("pk_score_counts")
        ),
    )
    op.bulk_insert(counts, _counted())


def downgrade() -> None:
    """Drop the table and the columns."""
    op.drop_table("score_counts")
    op.drop_index("ix_best_rank", table_name="best")
    op.create_index("ix_best_rank", "best", _RANK)
    for column in ("is_baseline", "degrees", "standard_error"):
        op.drop_column("best", column)


def _counted() -> list[dict[str, object]]:
    people = op.get_bind().execute(sa.text(_PEOPLE))
    counted = Counter(
        (name, _score_class(score), _error_class(error), degrees)
        for name, score, error, degrees in people
    )
    columns = ("benchmark", "score_class", "error_class", "degrees")
    return [
        dict(zip(columns, key, strict=True)) | {"people": number} for key, number in counted.items()
    ]


def _score_class(score: float) -> int:
    """As server/runs/leaderboard/score_counts.py had it: a migration must not change with the code."""
    if score < 2.0**-10:
        return 0
    mantissa, exponent = math.frexp(score)
    return min((exponent + 9) * 256 + math.floor((2.0 * mantissa - 1.0) * 256) + 1, 30 * 256 + 1)


def _error_class(error: float | None) -> int:
    if error is None:
        return 1000
    number = math.ceil(2 * math.log2(max(error, 2.0**-50)))
    return 1000 if number > 100 else number
