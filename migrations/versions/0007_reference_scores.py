"""Scores of the reference trials beside the result, for paired comparisons of runs."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Earlier results have no reference trials."""
    op.add_column("results", sa.Column("reference_scores", sa.JSON(none_as_null=True)))
    op.create_index(
        "ix_best_baselines",
        "best",
        ["benchmark"],
        sqlite_where=sa.text("is_baseline"),
        postgresql_where=sa.text("is_baseline"),
    )


def downgrade() -> None:
    """Drop the index and the column."""
    op.drop_index("ix_best_baselines", table_name="best")
    op.drop_column("results", "reference_scores")
