"""First schema.

Revision ID: 0031
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0031"  # the revisions before it were squashed into it
down_revision = None
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def _where(condition: str) -> dict[str, Any]:
    return dict.fromkeys(("sqlite_where", "postgresql_where"), sa.text(condition))


def upgrade() -> None:
    """Create all tables."""
    op.create_table(
        "audit_entries",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("actor", sa.String(80), nullable=False),
        sa.Column("address", sa.String(64), nullable=False),
        sa.Column("action", sa.String(40), nullable=False),
        sa.Column("target", sa.String(255), nullable=False),
        sa.Column("detail", sa.JSON(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_audit_entries"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_audit_entries_action_id", "audit_entries", ["action", "id"])
    op.create_index("ix_audit_entries_actor_id", "audit_entries", ["actor", "id"])
    op.create_index("ix_audit_entries_at", "audit_entries", ["at"])
    op.create_index("ix_audit_entries_target_id", "audit_entries", ["target", "id"])
    op.create_table(
        "counters",
        sa.Column("name", sa.String(40), nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("name", name="pk_counters"),
    )
    op.create_table(
        "data_folder",
        sa.Column("mark", sa.String(64), nullable=False),
        sa.Column("seed_proof", sa.String(64), nullable=True),
        sa.Column("result_code", sa.Text(), nullable=True),
        sa.PrimaryKeyConstraint("mark", name="pk_data_folder"),
    )
    op.create_table(
        "disk_usage",
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("bytes", sa.BigInteger(), nullable=False),
        sa.Column("count", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("kind", "name", name="pk_disk_usage"),
    )
    op.create_table(
        "paces",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("language", sa.String(40), nullable=False),
        sa.Column("wall_per_simulated", sa.Double(), nullable=False),
        sa.Column("runs", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("benchmark", "kind", "language", name="pk_paces"),
    )
    op.create_table(
        "publications",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("first_at", sa.Double(), nullable=False),
        sa.Column("withdrawn_at", sa.Double(), nullable=True),
        sa.PrimaryKeyConstraint("run_id", name="pk_publications"),
    )
    op.create_table(
        "rejudgements",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("reason", sa.String(500), nullable=False),
        sa.Column("chosen", sa.JSON(), nullable=False),
        sa.Column("created_by", sa.String(80), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("decision", sa.String(10), nullable=True),
        sa.Column("decided_by", sa.String(80), nullable=True),
        sa.Column("decided_at", sa.Double(), nullable=True),
        sa.CheckConstraint(
            "decision IN ('accepted', 'discarded')", name=op.f("ck_rejudgements_decision")
        ),
        sa.PrimaryKeyConstraint("id", name="pk_rejudgements"),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "score_counts",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("score_class", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("error_class", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("degrees", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("people", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint(
            "benchmark", "score_class", "error_class", "degrees", name="pk_score_counts"
        ),
    )
    op.create_table(
        "turns",
        sa.Column("owner", sa.String(80), nullable=False),
        sa.Column("served_at", sa.Double(), nullable=False),
        sa.Column("priority", sa.Integer(), server_default="0", nullable=False),
        sa.Column("queued", sa.Integer(), server_default="0", nullable=False),
        sa.Column("running", sa.Integer(), server_default="0", nullable=False),
        sa.Column("next_run", sa.BigInteger(), nullable=True),
        sa.Column("expected_s", sa.Double(), server_default="0", nullable=False),
        sa.PrimaryKeyConstraint("owner", name="pk_turns"),
    )
    op.create_index("ix_turns_idle", "turns", ["served_at"], **_where("queued = 0 AND running = 0"))
    op.create_index(
        "ix_turns_next",
        "turns",
        ["priority", "running", "served_at", "next_run"],
        **_where("queued > 0"),
    )
    op.create_index("ix_turns_running", "turns", ["priority"], **_where("running > 0"))
    op.create_table(
        "users",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("name", sa.String(40), nullable=False),
        sa.Column("name_key", sa.String(80), nullable=False),
        sa.Column("password_hash", sa.Text(), nullable=True),
        sa.Column("role", sa.String(10), server_default="user", nullable=False),
        sa.Column("is_baseline", sa.Boolean(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("disabled_at", sa.Double(), nullable=True),
        sa.Column("quota_day", sa.Integer(), nullable=True),
        sa.Column("notify_minutes", sa.Integer(), nullable=True),
        sa.Column("public_name", sa.String(80), server_default="", nullable=False),
        sa.Column("affiliation", sa.String(120), server_default="", nullable=False),
        sa.Column("paper_url", sa.String(300), server_default="", nullable=False),
        sa.Column("code_url", sa.String(300), server_default="", nullable=False),
        sa.CheckConstraint(
            "role IN ('user', 'teacher', 'organiser', 'admin')", name=op.f("ck_users_role")
        ),
        sa.PrimaryKeyConstraint("id", name="pk_users"),
        sa.UniqueConstraint("name_key", name="uq_users_name_key"),
    )
    op.create_table(
        "workers",
        sa.Column("name", sa.String(255), nullable=False),
        sa.Column("slots", sa.Integer(), nullable=False),
        sa.Column("level", sa.String(10), nullable=False),
        sa.Column("languages", sa.JSON(), nullable=False),
        sa.Column("findings", sa.JSON(), nullable=False),
        sa.Column("contents", sa.JSON(), server_default="{}", nullable=False),
        sa.Column("processes", sa.JSON(), server_default="{}", nullable=False),
        sa.Column("version", sa.String(40), server_default="", nullable=False),
        sa.Column("started_at", sa.Double(), nullable=False),
        sa.Column("seen_at", sa.Double(), nullable=False),
        sa.Column("drained_at", sa.Double(), nullable=True),
        sa.Column("result_code", sa.Text(), nullable=True),
        sa.PrimaryKeyConstraint("name", name="pk_workers"),
    )
    op.create_table(
        "account_deletions",
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("requested_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_account_deletions_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("user_id", name="pk_account_deletions"),
    )
    op.create_table(
        "browser_sessions",
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("expires_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_browser_sessions_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("hash", name="pk_browser_sessions"),
    )
    op.create_index("ix_browser_sessions_user_id", "browser_sessions", ["user_id"])
    op.create_table(
        "checks",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("config", sa.JSON(), nullable=False),
        sa.Column("program_sha256", sa.String(64), nullable=False),
        sa.Column("program_name", sa.String(255), nullable=False),
        sa.Column("language", sa.String(40), nullable=False),
        sa.Column("state", sa.String(10), nullable=False),
        sa.Column("queued_at", sa.Double(), nullable=False),
        sa.Column("finished_at", sa.Double(), nullable=True),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("worker", sa.String(255), nullable=True),
        sa.Column("lease_until", sa.Double(), nullable=True),
        sa.Column("answer", sa.JSON(), nullable=True),
        sa.CheckConstraint(
            "(state = 'done') = (answer IS NOT NULL)", name=op.f("ck_checks_answer")
        ),
        sa.CheckConstraint("state IN ('queued', 'running', 'done')", name=op.f("ck_checks_state")),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_checks_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_checks"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_checks_state_id", "checks", ["state", "id"])
    op.create_index("ix_checks_user_id", "checks", ["user_id"])
    op.create_table(
        "classes",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("teacher_id", _ROW_ID, nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("code", sa.String(16), nullable=False),
        sa.Column("shows_ranking", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("archived_at", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["teacher_id"], ["users.id"], name="fk_classes_teacher_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_classes"),
        sa.UniqueConstraint("code", name="uq_classes_code"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_classes_teacher_id", "classes", ["teacher_id"])
    op.create_table(
        "invitations",
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=True),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("expires_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_invitations_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("hash", name="pk_invitations"),
    )
    op.create_index("ix_invitations_user_id", "invitations", ["user_id"])
    op.create_table(
        "linked_identities",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("issuer", sa.String(300), nullable=False),
        sa.Column("subject", sa.String(255), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("label", sa.String(120), nullable=False),
        sa.Column("linked_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_linked_identities_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_linked_identities"),
        sa.UniqueConstraint("issuer", "subject", name="uq_linked_identities_issuer_subject"),
        sa.UniqueConstraint("user_id", "issuer", name="uq_linked_identities_user_id_issuer"),
    )
    op.create_table(
        "mail_addresses",
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("address", sa.String(254), nullable=True),
        sa.Column("address_hash", sa.String(64), nullable=True),
        sa.Column("pending", sa.String(254), nullable=True),
        sa.Column("pending_hash", sa.String(64), nullable=True),
        sa.Column("pending_until", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_mail_addresses_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("user_id", name="pk_mail_addresses"),
        sa.UniqueConstraint("pending_hash", name="uq_mail_addresses_pending_hash"),
    )
    op.create_index("ix_mail_addresses_address_hash", "mail_addresses", ["address_hash"])
    op.create_table(
        "outgoing_mails",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=True),
        sa.Column("address_hash", sa.String(64), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("next_try_at", sa.Double(), nullable=False),
        sa.Column("tries", sa.Integer(), nullable=False),
        sa.Column("ended_at", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_outgoing_mails_user_id", ondelete="SET NULL"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_outgoing_mails"),
        sqlite_autoincrement=True,
    )
    op.create_index(
        "ix_outgoing_mails_address_hash_created", "outgoing_mails", ["address_hash", "created_at"]
    )
    op.create_index(
        "ix_outgoing_mails_due", "outgoing_mails", ["next_try_at"], **_where("ended_at IS NULL")
    )
    op.create_index("ix_outgoing_mails_user_id", "outgoing_mails", ["user_id"])
    op.create_table(
        "password_resets",
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("expires_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_password_resets_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("hash", name="pk_password_resets"),
    )
    op.create_index("ix_password_resets_user_id", "password_resets", ["user_id"])
    op.create_table(
        "rank_points",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("at", sa.Double(), nullable=False),
        sa.Column("rank", sa.Integer(), nullable=True),
        sa.Column("people", sa.Integer(), nullable=False),
        sa.Column("score", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_rank_points_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_rank_points"),
    )
    op.create_index(
        "ix_rank_points_user_benchmark_id", "rank_points", ["user_id", "benchmark", "id"]
    )
    op.create_table(
        "runs",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("owner", sa.String(80), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=True),
        sa.Column("guest", sa.String(64), nullable=True),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("config", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=True),
        sa.Column("submission", sa.String(64), nullable=True),
        sa.Column("trials", sa.Integer(), nullable=False),
        sa.Column("controller", sa.String(80), nullable=False),
        sa.Column("program_sha256", sa.String(64), nullable=True),
        sa.Column("program_name", sa.String(255), nullable=True),
        sa.Column("language", sa.String(40), nullable=True),
        sa.Column("program_parameters", sa.JSON(), nullable=True),
        sa.Column("title", sa.String(120), nullable=False),
        sa.Column("notes", sa.Text(), nullable=False),
        sa.Column("rerun_of", sa.BigInteger(), nullable=True),
        sa.Column("rejudges", sa.BigInteger(), nullable=True),
        sa.Column("data_run", sa.BigInteger(), nullable=True),
        sa.Column("sweep_id", sa.BigInteger(), nullable=True),
        sa.Column("sweep_cell", sa.Integer(), nullable=True),
        sa.Column("expected_s", sa.Double(), nullable=True),
        sa.Column("request_id", sa.String(64), nullable=True),
        sa.Column("state", sa.String(10), nullable=False),
        sa.Column("cause", sa.String(20), nullable=True),
        sa.Column("detail", sa.JSON(), nullable=False),
        sa.Column("queued_at", sa.Double(), nullable=False),
        sa.Column("started_at", sa.Double(), nullable=True),
        sa.Column("finished_at", sa.Double(), nullable=True),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("failures", sa.Integer(), nullable=False),
        sa.Column("interruptions", sa.Integer(), server_default="0", nullable=False),
        sa.Column("worker", sa.String(255), nullable=True),
        sa.Column("lease_until", sa.Double(), nullable=True),
        sa.Column("progress", sa.Double(), nullable=False),
        sa.Column("t_simulated", sa.Double(), nullable=False),
        sa.Column("isolation", sa.String(10), nullable=True),
        sa.Column("public", sa.Boolean(), nullable=False),
        sa.Column("published_at", sa.Double(), nullable=True),
        sa.Column("anonymous", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("program_public", sa.Boolean(), server_default=sa.true(), nullable=False),
        sa.Column("licence", sa.String(40), nullable=True),
        sa.Column("draw", sa.Integer(), nullable=True),
        sa.Column("data_bytes", sa.BigInteger(), server_default="0", nullable=False),
        sa.Column("data_measured", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("data_deleted_at", sa.Double(), nullable=True),
        sa.Column("deleted_at", sa.Double(), nullable=True),
        sa.CheckConstraint("(kind = 'ranked') = (seed IS NULL)", name=op.f("ck_runs_hidden_seed")),
        sa.CheckConstraint("(state = 'failed') = (cause IS NOT NULL)", name=op.f("ck_runs_cause")),
        sa.CheckConstraint(
            "state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')",
            name=op.f("ck_runs_state"),
        ),
        sa.ForeignKeyConstraint(["user_id"], ["users.id"], name="fk_runs_user_id"),
        sa.PrimaryKeyConstraint("id", name="pk_runs"),
    )
    op.create_index("ix_runs_benchmark_finished", "runs", ["benchmark", "finished_at"])
    op.create_index("ix_runs_benchmark_state_id", "runs", ["benchmark", "state", "id"])
    op.create_index(
        "ix_runs_finished",
        "runs",
        ["finished_at", "state", "t_simulated", "rejudges"],
        **_where("finished_at IS NOT NULL"),
    )
    op.create_index("ix_runs_guest_id", "runs", ["guest", "id"], **_where("guest IS NOT NULL"))
    op.create_index(
        "ix_runs_owner_bytes", "runs", ["owner", "data_bytes"], **_where("data_bytes > 0")
    )
    op.create_index("ix_runs_owner_id", "runs", ["owner", "id"], **_where("deleted_at IS NULL"))
    op.create_index("ix_runs_owner_public_id", "runs", ["owner", "public", "id"])
    op.create_index("ix_runs_owner_state_finished", "runs", ["owner", "state", "finished_at"])
    op.create_index("ix_runs_program_sha256", "runs", ["program_sha256"])
    op.create_index("ix_runs_public_id", "runs", ["public", "id"])
    op.create_index(
        "ix_runs_queued", "runs", ["owner", "id", "language"], **_where("state = 'queued'")
    )
    op.create_index("ix_runs_queued_at", "runs", ["queued_at"], **_where("state = 'queued'"))
    op.create_index("ix_runs_rejudges", "runs", ["rejudges"], **_where("rejudges IS NOT NULL"))
    op.create_index("ix_runs_running", "runs", ["owner"], **_where("state = 'running'"))
    op.create_index("ix_runs_state_id", "runs", ["state", "id"])
    op.create_index(
        "ix_runs_submission", "runs", ["submission"], **_where("submission IS NOT NULL")
    )
    op.create_index(
        "ix_runs_sweep", "runs", ["sweep_id", "sweep_cell"], **_where("sweep_id IS NOT NULL")
    )
    op.create_index(
        "ix_runs_user_benchmark_kind_queued", "runs", ["user_id", "benchmark", "kind", "queued_at"]
    )
    op.create_table(
        "submission_keys",
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("key", sa.String(64), nullable=False),
        sa.Column("request", sa.String(64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_submission_keys_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("user_id", "key", name="pk_submission_keys"),
    )
    op.create_index(
        "ix_submission_keys_user_id_created_at", "submission_keys", ["user_id", "created_at"]
    )
    op.create_table(
        "sweeps",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=True),
        sa.Column("guest", sa.String(64), nullable=True),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("title", sa.String(120), nullable=False),
        sa.Column("axes", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_sweeps_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_sweeps"),
    )
    op.create_index("ix_sweeps_user_id", "sweeps", ["user_id"])
    op.create_table(
        "tokens",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("name", sa.String(80), nullable=False),
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("scopes", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("expires_at", sa.Double(), nullable=True),
        sa.Column("last_used_at", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_tokens_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_tokens"),
        sa.UniqueConstraint("hash", name="uq_tokens_hash"),
    )
    op.create_index("ix_tokens_user_id", "tokens", ["user_id"])
    op.create_table(
        "assignments",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("class_id", _ROW_ID, nullable=False),
        sa.Column("title", sa.String(120), nullable=False),
        sa.Column("instructions", sa.Text(), nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("config", sa.JSON(), nullable=False),
        sa.Column("seed", sa.BigInteger(), nullable=True),
        sa.Column("trials", sa.Integer(), nullable=False),
        sa.Column("deadline", sa.Double(), nullable=True),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.CheckConstraint("kind IN ('practice', 'ranked')", name=op.f("ck_assignments_kind")),
        sa.ForeignKeyConstraint(
            ["class_id"], ["classes.id"], name="fk_assignments_class_id_classes", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_assignments"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_assignments_class_id", "assignments", ["class_id"])
    op.create_table(
        "best",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        sa.Column("score", sa.Double(), nullable=False),
        sa.Column("score_low", sa.Double(), nullable=False),
        sa.Column("score_high", sa.Double(), nullable=False),
        sa.Column("standard_error", sa.Double(), nullable=True),
        sa.Column("degrees", sa.Integer(), server_default="0", nullable=False),
        sa.Column("is_baseline", sa.Boolean(), server_default=sa.false(), nullable=False),
        sa.Column("level_held", sa.Double(), nullable=True),
        sa.Column("submissions", sa.Integer(), server_default="1", nullable=False),
        sa.Column("reached_at", sa.Double(), nullable=False),
        sa.Column("language", sa.String(40), server_default="", nullable=False),
        sa.Column("vehicle", sa.String(40), server_default="", nullable=False),
        sa.Column("tracker", sa.String(40), server_default="", nullable=False),
        sa.Column("metrics", sa.JSON(), nullable=True),
        sa.CheckConstraint("score > -1e300 AND score < 1e300", name=op.f("ck_best_finite")),
        sa.ForeignKeyConstraint(["run_id"], ["runs.id"], name="fk_best_run_id", ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_best_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("benchmark", "user_id", name="pk_best"),
        sa.UniqueConstraint("run_id", name="uq_best_run_id"),
    )
    op.create_index(
        "ix_best_rank",
        "best",
        ["benchmark", sa.text("score DESC"), "reached_at", "run_id", "is_baseline"],
    )
    op.create_index("ix_best_baselines", "best", ["benchmark"], **_where("is_baseline"))
    op.create_index("ix_best_without_metrics", "best", ["run_id"], **_where("metrics IS NULL"))
    op.create_table(
        "memberships",
        sa.Column("class_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("joined_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["class_id"], ["classes.id"], name="fk_memberships_class_id_classes", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_memberships_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("class_id", "user_id", name="pk_memberships"),
    )
    op.create_index("ix_memberships_user_id_class_id", "memberships", ["user_id", "class_id"])
    op.create_table(
        "rejudged_runs",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("rejudgement_id", _ROW_ID, nullable=False),
        sa.Column("outcome", sa.String(10), nullable=True),
        sa.Column("before", sa.JSON(), nullable=True),
        sa.Column("after", sa.JSON(), nullable=True),
        sa.Column("metrics", sa.JSON(), nullable=True),
        sa.Column("metrics_count", sa.Integer(), nullable=False),
        sa.Column("replaced_at", sa.Double(), nullable=True),
        sa.Column("earlier", sa.JSON(), nullable=True),
        sa.CheckConstraint(
            "outcome IN ('same', 'different')", name=op.f("ck_rejudged_runs_outcome")
        ),
        sa.ForeignKeyConstraint(
            ["rejudgement_id"],
            ["rejudgements.id"],
            name="fk_rejudged_runs_rejudgement_id",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_rejudged_runs_run_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("run_id", name="pk_rejudged_runs"),
    )
    op.create_index(
        "ix_rejudged_runs_rejudgement_id_outcome",
        "rejudged_runs",
        ["rejudgement_id", "outcome", "run_id"],
    )
    op.create_table(
        "results",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("attempt", sa.Integer(), nullable=False),
        sa.Column("digest", sa.String(64), nullable=True),
        sa.Column("score", sa.Double(), nullable=True),
        sa.Column("score_low", sa.Double(), nullable=True),
        sa.Column("score_high", sa.Double(), nullable=True),
        sa.Column("level_held", sa.Double(), nullable=True),
        sa.Column("rankable", sa.Boolean(), nullable=False),
        sa.Column("not_ranked", sa.Text(), nullable=True),
        sa.Column("reference_scores", sa.JSON(), nullable=True),
        sa.Column("error_curve", sa.JSON(), nullable=True),
        sa.Column("metrics", sa.JSON(), nullable=True),
        sa.Column("manifest", sa.JSON(), nullable=True),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.CheckConstraint(
            "score IS NULL OR (score > -1e300 AND score < 1e300)", name=op.f("ck_results_finite")
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_results_run_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("run_id", name="pk_results"),
    )
    op.create_table(
        "run_notices",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_run_notices_run_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_run_notices_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_run_notices"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_run_notices_run_id", "run_notices", ["run_id"])
    op.create_index("ix_run_notices_user_id", "run_notices", ["user_id"])
    op.create_table(
        "verifications",
        sa.Column("again_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        sa.Column("requested_at", sa.Double(), nullable=False),
        sa.Column("ended_at", sa.Double(), nullable=True),
        sa.Column("version", sa.String(40), nullable=True),
        sa.Column("digest", sa.String(64), nullable=True),
        sa.Column("cause", sa.String(20), nullable=True),
        sa.Column("score", sa.Double(), nullable=True),
        sa.Column("score_low", sa.Double(), nullable=True),
        sa.Column("score_high", sa.Double(), nullable=True),
        sa.Column("standard_error", sa.Double(), nullable=True),
        sa.Column("degrees", sa.Integer(), server_default="0", nullable=False),
        sa.ForeignKeyConstraint(
            ["again_id"], ["runs.id"], name="fk_verifications_again_id", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_verifications_run_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("again_id", name="pk_verifications"),
    )
    op.create_index("ix_verifications_run_id", "verifications", ["run_id", "again_id"])
    op.create_table(
        "assigned_runs",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("assignment_id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("score", sa.Double(), nullable=True),
        sa.ForeignKeyConstraint(
            ["assignment_id"],
            ["assignments.id"],
            name="fk_assigned_runs_assignment_id_assignments",
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_assigned_runs_run_id_runs", ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_assigned_runs_user_id_users", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("run_id", name="pk_assigned_runs"),
    )
    op.create_index(
        "ix_assigned_runs_assignment_id_user_id",
        "assigned_runs",
        ["assignment_id", "user_id", "score", "run_id"],
    )
    op.create_index("ix_assigned_runs_user_id", "assigned_runs", ["user_id"])


def downgrade() -> None:
    """Drop all tables."""
    for table in (
        "assigned_runs",
        "verifications",
        "run_notices",
        "results",
        "rejudged_runs",
        "memberships",
        "best",
        "assignments",
        "tokens",
        "sweeps",
        "submission_keys",
        "runs",
        "rank_points",
        "password_resets",
        "outgoing_mails",
        "mail_addresses",
        "linked_identities",
        "invitations",
        "classes",
        "checks",
        "browser_sessions",
        "account_deletions",
        "workers",
        "users",
        "turns",
        "score_counts",
        "rejudgements",
        "publications",
        "paces",
        "disk_usage",
        "data_folder",
        "counters",
        "audit_entries",
    ):
        op.drop_table(table)
