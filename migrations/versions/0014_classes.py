"""Classes with a code, their assignments, and the runs that were made for them."""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def _to(table: str, column: str, target: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_{table}_{column}_{target}")
    return sa.ForeignKeyConstraint([column], [f"{target}.id"], name=name, ondelete="CASCADE")


def upgrade() -> None:
    """Create the tables; the table of runs stays as it is."""
    op.create_table(
        "classes",
        sa.Column("id", _ID, nullable=False),
        sa.Column("teacher_id", _ID, nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("code", sa.String(16), nullable=False),
        sa.Column("shows_ranking", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("archived_at", sa.Double()),
        _to("classes", "teacher_id", "users"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_classes")),
        sa.UniqueConstraint("code", name=op.f("uq_classes_code")),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_classes_teacher_id", "classes", ["teacher_id"])
    op.create_table(
        "memberships",
        sa.Column("class_id", _ID, nullable=False),
        sa.Column("user_id", _ID, nullable=False),
        sa.Column("joined_at", sa.Double(), nullable=False),
        _to("memberships", "class_id", "classes"),
        _to("memberships", "user_id", "users"),
        sa.PrimaryKeyConstraint("class_id", "user_id", name=op.f("pk_memberships")),
    )
    op.create_index("ix_memberships_user_id_class_id", "memberships", ["user_id", "class_id"])
    op.create_table(
        "assignments",
        sa.Column("id", _ID, nullable=False),
        sa.Column("class_id", _ID, nullable=False),
        sa.Column("title", sa.String(120), nullable=False),
        sa.Column("instructions", sa.Text(), nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("config", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger()),
        sa.Column("trials", sa.Integer(), nullable=False),
        sa.Column("deadline", sa.Double()),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.CheckConstraint("kind IN ('practice', 'ranked')", name=op.f("ck_assignments_kind")),
        _to("assignments", "class_id", "classes"),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_assignments")),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_assignments_class_id", "assignments", ["class_id"])
    op.create_table(
        "assigned_runs",
        sa.Column("run_id", _ID, nullable=False),
        sa.Column("assignment_id", _ID, nullable=False),
        sa.Column("user_id", _ID, nullable=False),
        sa.Column("score", sa.Double()),
        _to("assigned_runs", "run_id", "runs"),
        _to("assigned_runs", "assignment_id", "assignments"),
        _to("assigned_runs", "user_id", "users"),
        sa.PrimaryKeyConstraint("run_id", name=op.f("pk_assigned_runs")),
    )
    op.create_index("ix_assigned_runs_user_id", "assigned_runs", ["user_id"])
    op.create_index(
        "ix_assigned_runs_assignment_id_user_id",
        "assigned_runs",
        ["assignment_id", "user_id", "score", "run_id"],
    )


def downgrade() -> None:
    """Drop the tables; the runs stay those of their owners."""
    for table in ("assigned_runs", "assignments", "memberships", "classes"):
        op.drop_table(table)
