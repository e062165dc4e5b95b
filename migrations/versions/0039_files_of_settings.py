"""Files that settings of competitions and their runs name, such as a record of currents.

Revision ID: 0039
Revises: 0038
"""

import sqlalchemy as sa
from alembic import op

revision = "0039"
down_revision = "0038"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_TABLES = {"run_files": ("run_id", "runs"), "competition_files": ("competition_id", "competitions")}


def upgrade() -> None:
    """Add the tables; no setting names a file yet."""
    for table, (owner, owners) in _TABLES.items():
        op.create_table(
            table,
            sa.Column(owner, _ROW_ID, autoincrement=False, nullable=False),
            sa.Column("setting", sa.String(length=40), nullable=False),
            sa.Column("sha256", sa.String(length=64), nullable=False),
            sa.ForeignKeyConstraint(
                [owner], [f"{owners}.id"], name=f"fk_{table}_{owner}", ondelete="CASCADE"
            ),
            sa.PrimaryKeyConstraint(owner, "setting", name=f"pk_{table}"),
        )
        op.create_index(f"ix_{table}_sha256", table, ["sha256"])


def downgrade() -> None:
    """Forget which files they were; runs with such a file can no longer be evaluated."""
    for table in _TABLES:
        op.drop_table(table)
