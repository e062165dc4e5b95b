"""Workers report their side processes; a column of runs that nothing read is dropped."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Workers that are already listed have reported nothing yet."""
    op.add_column(
        "workers", sa.Column("processes", sa.JSON(), nullable=False, server_default="{}")
    )
    op.drop_column("runs", "cancel_requested")


def downgrade() -> None:
    """No run was ever asked to cancel: a cancelled run changes its state."""
    op.add_column(
        "runs",
        sa.Column("cancel_requested", sa.Boolean(), nullable=False, server_default=sa.false()),
    )
    with op.batch_alter_table("workers") as batch:
        batch.drop_column("processes")
