"""How the side processes of each worker are doing, as the worker itself reports it."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; empty for workers that are already listed."""
    op.add_column(
        "workers", sa.Column("processes", sa.JSON(), nullable=False, server_default="{}")
    )


def downgrade() -> None:
    """Drop it."""
    with op.batch_alter_table("workers") as batch:
        batch.drop_column("processes")
