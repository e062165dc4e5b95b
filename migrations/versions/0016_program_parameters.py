"""The parameters that an uploaded program declares."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column; programs of earlier runs declare none."""
    op.add_column("runs", sa.Column("program_parameters", sa.JSON(), nullable=True))


def downgrade() -> None:
    """Drop the column."""
    op.drop_column("runs", "program_parameters")
