"""Lost workers are counted apart from failed evaluations; a check names the worker that has it."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """What earlier versions counted as failures stays so: they did not tell one from the other."""
    op.add_column(
        "runs", sa.Column("interruptions", sa.Integer(), nullable=False, server_default="0")
    )
    op.add_column("checks", sa.Column("worker", sa.String(255), nullable=True))


def downgrade() -> None:
    """Only running checks have a worker: one that is restarted takes them up again."""
    op.drop_column("checks", "worker")
    op.drop_column("runs", "interruptions")
