"""How much the data of a run take on disk, and when they were deleted."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """The maintenance process measures earlier runs; until then they count as empty."""
    op.add_column(
        "runs", sa.Column("data_bytes", sa.BigInteger(), nullable=False, server_default="0")
    )
    op.add_column(
        "runs", sa.Column("data_measured", sa.Boolean(), nullable=False, server_default=sa.false())
    )
    op.add_column("runs", sa.Column("data_deleted_at", sa.Double(), nullable=True))
    stored = sa.text("data_bytes > 0")
    op.create_index(
        "ix_runs_owner_bytes",
        "runs",
        ["owner", "data_bytes"],
        sqlite_where=stored,
        postgresql_where=stored,
    )


def downgrade() -> None:
    """Drop the index and the columns."""
    op.drop_index("ix_runs_owner_bytes", "runs")
    for column in ("data_deleted_at", "data_measured", "data_bytes"):
        op.drop_column("runs", column)
