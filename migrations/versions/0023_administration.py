"""What operators decide (drained workers, disabled accounts, quotas), and who did what."""

import sqlalchemy as sa
from alembic import op

revision = "0023"
down_revision = "0022"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Nobody is disabled and no worker drained; the log begins now."""
    op.add_column("users", sa.Column("disabled_at", sa.Double(), nullable=True))
    op.add_column("users", sa.Column("quota_day", sa.Integer(), nullable=True))
    op.add_column("workers", sa.Column("drained_at", sa.Double(), nullable=True))
    version = sa.Column("version", sa.String(40), nullable=False, server_default="")
    op.add_column("workers", version)
    op.create_table(
        "audit_entries",
        sa.Column("id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("actor", sa.String(80), nullable=False),
        sa.Column("address", sa.String(64), nullable=False),
        sa.Column("action", sa.String(40), nullable=False),
        sa.Column("target", sa.String(255), nullable=False),
        sa.Column("detail", sa.JSON(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_audit_entries")),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_audit_entries_at", "audit_entries", ["at"])
    for column in ("action", "actor", "target"):
        op.create_index(f"ix_audit_entries_{column}_id", "audit_entries", [column, "id"])


def downgrade() -> None:
    """Drained workers claim runs again, disabled accounts can sign in, and the log is lost."""
    op.drop_table("audit_entries")
    op.drop_column("workers", "version")
    op.drop_column("workers", "drained_at")
    op.drop_column("users", "quota_day")
    op.drop_column("users", "disabled_at")
