"""Workers report what programs find in their boxes."""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; a worker fills it when it starts."""
    op.add_column(
        "workers",
        sa.Column("contents", sa.JSON(none_as_null=True), nullable=False, server_default="{}"),
    )


def downgrade() -> None:
    """Drop the column."""
    op.drop_column("workers", "contents")
