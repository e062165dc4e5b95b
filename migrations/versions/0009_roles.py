"""Accounts have a role instead of a mark for admins; an invitation knows who made it."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None

_ROLE = """
    ALTER TABLE users ADD COLUMN role VARCHAR(10) DEFAULT 'user' NOT NULL
    CONSTRAINT ck_users_role CHECK (role IN ('user', 'teacher', 'organiser', 'admin'))
"""


def upgrade() -> None:
    """Add the role with its rule in one statement: SQLite adds no rule to a column later."""
    op.execute(_ROLE)
    op.execute("UPDATE users SET role = 'admin' WHERE is_admin")
    op.drop_column("users", "is_admin")
    with op.batch_alter_table("invitations") as batch:
        batch.add_column(
            sa.Column("user_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"))
        )
        batch.create_foreign_key(
            "fk_invitations_user_id_users", "users", ["user_id"], ["id"], ondelete="CASCADE"
        )
        batch.create_index("ix_invitations_user_id", ["user_id"])


def downgrade() -> None:
    """Teachers and organisers become users."""
    with op.batch_alter_table("invitations") as batch:
        batch.drop_index("ix_invitations_user_id")
        batch.drop_constraint("fk_invitations_user_id_users", type_="foreignkey")
        batch.drop_column("user_id")
    op.add_column(
        "users", sa.Column("is_admin", sa.Boolean(), nullable=False, server_default=sa.false())
    )
    op.execute("UPDATE users SET is_admin = (role = 'admin')")
    op.drop_column("users", "role")
