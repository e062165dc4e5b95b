"""The rights of a database role for workers, on PostgreSQL: what they need to evaluate runs.

A worker runs programs of strangers. With this role, one that was taken over reads no password,
session, token or audit entry, and adds and deletes neither runs nor accounts.
"""

from sqlalchemy import Connection, inspect, text

# Tables that workers only read, those that they also change, those whose rows they also add and
# delete.
READ = (
    *("alembic_version", "data_folder", "assignments", "classes", "memberships", "sweeps"),
    *("rejudgements", "run_files", "run_parts", "seen_submissions"),
    *("competitions", "competition_files", "competition_rounds"),
)
CHANGED = ("runs", "assigned_runs", "entries", "rejudged_runs", "verifications")
OWN = (
    *("best", "checks", "counters", "disk_usage", "paces", "rank_points", "results"),
    *("best_methods", "publications", "score_counts", "turns", "workers"),
)
ADDED = ("run_notices", "seen_submissions")  # to which they only add
_USERS_HIDDEN = frozenset(("password_hash",))
# What only the role of the service may do; see seamark.worker.service.maintenance.
BEYOND = ("users", "audit_entries")


class NotPostgreSQL(Exception):
    """The database has no roles."""


def grant(connection: Connection, role: str) -> None:
    """Give a role the rights of a worker, and take all others of this schema from it.

    Raises
    ------
    NotPostgreSQL
        SQLite knows no roles.
    ProgrammingError
        There is no such role.
    """
    if connection.dialect.name != "postgresql":
        raise NotPostgreSQL("Only PostgreSQL has roles: with SQLite all processes share a file")
    name = connection.dialect.identifier_preparer.quote_identifier(role)
    known = {column["name"] for column in inspect(connection).get_columns("users")}
    shown = ", ".join(sorted(known - _USERS_HIDDEN))
    for statement in (
        f"REVOKE ALL ON ALL TABLES IN SCHEMA public FROM {name}",
        f"GRANT USAGE ON SCHEMA public TO {name}",
        f"GRANT SELECT ON {', '.join((*READ, *CHANGED))} TO {name}",
        f"GRANT SELECT ({shown}) ON users TO {name}",
        f"GRANT UPDATE ON {', '.join(CHANGED)} TO {name}",
        f"GRANT INSERT ON {', '.join(ADDED)} TO {name}",
        f"GRANT SELECT, INSERT, UPDATE, DELETE ON {', '.join(OWN)} TO {name}",
        f"GRANT USAGE ON ALL SEQUENCES IN SCHEMA public TO {name}",
    ):
        connection.execute(text(statement))


def is_restricted(connection: Connection) -> bool:
    """Return whether this connection has the rights of a worker only."""
    if connection.dialect.name != "postgresql":
        return False
    query = text("SELECT has_table_privilege(:table, 'DELETE')")
    return not all(connection.scalar(query, {"table": table}) for table in BEYOND)
