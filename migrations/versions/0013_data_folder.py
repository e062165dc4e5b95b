"""The mark by which the database knows its data folder."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table; the next start marks the folder."""
    op.create_table(
        "data_folder",
        sa.Column("mark", sa.String(64), nullable=False),
        sa.PrimaryKeyConstraint("mark", name=op.f("pk_data_folder")),
    )


def downgrade() -> None:
    """Drop the table."""
    op.drop_table("data_folder")
