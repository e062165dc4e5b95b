"""What lists of runs need: deleted runs, and a curve of the error that reads no files."""

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None

_KEPT = sa.text("deleted_at IS NULL")


def upgrade() -> None:
    """Earlier runs have no curve."""
    op.add_column("runs", sa.Column("deleted_at", sa.Double(), nullable=True))
    op.add_column("results", sa.Column("error_curve", sa.JSON(none_as_null=True), nullable=True))
    op.drop_index("ix_runs_owner_id", "runs")
    columns = ["owner", "id"]
    op.create_index(
        "ix_runs_owner_id", "runs", columns, sqlite_where=_KEPT, postgresql_where=_KEPT
    )


def downgrade() -> None:
    """Deleted runs are listed again, though without what they were about."""
    op.drop_index("ix_runs_owner_id", "runs")
    op.create_index("ix_runs_owner_id", "runs", ["owner", "id"])
    op.drop_column("results", "error_curve")
    op.drop_column("runs", "deleted_at")
