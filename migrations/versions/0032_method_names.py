"""Methods of published runs have names.

Revision ID: 0032
Revises: 0031
"""

import sqlalchemy as sa
from alembic import op

revision = "0032"
down_revision = "0031"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Published runs keep the names that leaderboards showed: their titles.

    One without a title has no name, and is shown by its program as before.
    """
    name = sa.Column("method", sa.String(60), server_default="", nullable=False)
    op.add_column("runs", name)
    op.execute("UPDATE runs SET method = TRIM(SUBSTR(title, 1, 60)) WHERE public AND title <> ''")


def downgrade() -> None:
    """Leaderboards show titles again."""
    op.drop_column("runs", "method")
