"""Keys by which repeated submissions are recognised."""

import sqlalchemy as sa
from alembic import op

revision = "0022"
down_revision = "0021"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table; earlier submissions have no key."""
    row_id = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "submission_keys",
        sa.Column("user_id", row_id, nullable=False),
        sa.Column("key", sa.String(64), nullable=False),
        sa.Column("request", sa.String(64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name=op.f("fk_submission_keys_user_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("user_id", "key", name=op.f("pk_submission_keys")),
    )
    op.create_index(
        op.f("ix_submission_keys_user_id_created_at"), "submission_keys", ["user_id", "created_at"]
    )


def downgrade() -> None:
    """Forget the keys."""
    op.drop_table("submission_keys")
