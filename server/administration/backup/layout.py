"""What a backup has, by the names of its members."""

import re
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from seamark.server.runs.data.files import RUNS_PER_FOLDER

FORMAT = 1
HEADER = "seamark-backup.json"  # first
DELETED = "deleted.json"  # run -> when its data were deleted, while the backup was made
SUMMARY = "summary.json"
KEYS = ("seed_key", "secret")
_KEY = re.compile(r"keys/(seed_key|secret)")
_TABLE = re.compile(r"database/([a-z_]+)/\d+\.jsonl")
_FILE = re.compile(r"programs/[0-9a-f]{64}|runs/\d+/\d+/\d+/[A-Za-z0-9_][A-Za-z0-9_.-]*")


class Header(BaseModel):
    """What has to be known before anything is restored."""

    model_config = ConfigDict(extra="ignore")

    format: int
    version: str  # of Seamark
    schema_revision: str
    made_at: float  # the database is as it was then
    objects: bool  # programs and data of runs are in object storage, not in the backup


class Summary(BaseModel):
    """What a complete backup has."""

    model_config = ConfigDict(extra="ignore")

    rows: dict[str, int]  # by table
    runs_with_data: int
    programs: int
    bytes: int


def of_chunk(table: str, number: int) -> str:
    """Return the member with a chunk of a table."""
    return f"database/{table}/{number:06}.jsonl"


def of_program(sha256: str) -> str:
    """Return the member with a program."""
    return f"programs/{sha256}"


def of_run_file(run_id: int, attempt: int, name: str) -> str:
    """Return the member with a file of a run, which is its path in the data folder too."""
    return f"runs/{run_id // RUNS_PER_FOLDER}/{run_id}/{attempt}/{name}"


def of_key(name: str) -> str:
    """Return the member with a key."""
    return f"keys/{name}"


def table_of(member: str) -> str | None:
    """Return the table of a chunk; None for other members."""
    match = _TABLE.fullmatch(member)
    return match[1] if match else None


def key_of(member: str) -> str | None:
    """Return the name of a key; None for other members."""
    match = _KEY.fullmatch(member)
    return match[1] if match else None


def path_of(member: str, data: Path) -> Path | None:
    """Return where a program or a file of a run belongs; None for other members."""
    return data / member if _FILE.fullmatch(member) else None
