"""docs/security.md says what is so: its tests are there, and its limits are those of the code."""

import re
from pathlib import Path

import pytest

from performance.commands import TABLES
from seamark.embedded import connections, protocols, web_server, web_worker
from seamark.mission_logs import mapping
from seamark.mission_logs import process as log_process
from seamark.programs import preparation
from seamark.server.accounts import accounts
from seamark.server.api.requests import request_body
from seamark.server.api.requests.schemas import CONFIG_MAX
from seamark.server.pages.docs import search_index
from seamark.server.programs import reader_process, source_differences
from seamark.server.runs.downloads import conversion_process
from seamark.server.web import body_limits, received_body
from seamark.sim.vehicles import toml_reading

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs/security.md").read_text()
ROWS: dict[str, str] = {}
for _line in TEXT.partition("## Every byte")[2].partition("###")[0].splitlines():
    ROWS[_line.strip("| ").partition(" | ")[0]] = _line


def test_every_test_that_it_names_is_there() -> None:
    named = set(re.findall(r"`(tests/[^`]+)`", TEXT))

    assert len(named) > 15
    assert [path for path in sorted(named) if not (ROOT / path).is_file()] == []


def test_every_command_of_performance_that_it_names_is_there() -> None:
    named = set(re.findall(r"`\./run\s+performance\s+(\w+)`", TEXT))

    assert named == {"strangers_bytes", "upgrade_flood"}
    assert named <= set(TABLES)


@pytest.mark.parametrize(
    ("row", "limits"),
    [
        (
            "connections",
            (
                f"{connections.CONNECTIONS:,}",
                f"{connections.WAITING_OF_ADDRESS:,}",
                f"{web_worker.ACCEPTED_AT_ONCE} accepted",
            ),
        ),
        (
            "request line and headers",
            (f"{protocols.HEAD_S:g} s", f"{connections.READ_BYTES >> 10} KiB read"),
        ),
        (
            "framing of bodies: chunks, extensions, trailers",
            (
                f"{received_body.PATIENCE_S:g} s",
                f"{received_body.SLOWEST_BYTES_PER_S >> 10} KiB/s",
            ),
        ),
        ("a body that is refused", (f"{protocols.DISCARDED_MAX >> 20} MiB",)),
        ("handshake of a WebSocket", (f"{protocols.ACCEPT_S:g} s",)),
        (
            "frames of a WebSocket",
            (
                f"{protocols.MESSAGE_MAX >> 10} KiB",
                f"{protocols.FRAGMENTS_MAX:,} pieces",
                f"{protocols.PINGS_MAX:,} pings",
            ),
        ),
        ("Idempotency-Key", (str(request_body.KEY_MAX),)),
        ("JSON", (f"{body_limits.JSON_MAX_BYTES >> 10} KiB", f"{CONFIG_MAX} settings")),
        (
            "forms, URL-encoded and multipart",
            (f"{body_limits.FORM_MAX_BYTES >> 10} KiB", f"{body_limits.FIELD_MAX:,}"),
        ),
        ("passwords", (f"{accounts.PASSWORD_MAX} characters",)),
        ("words of a search", (f"{search_index.QUERY_MAX} characters",)),
        (
            "programs: source",
            (f"{preparation.TEXT_MAX_BYTES >> 20} MiB", f"{reader_process.CPU_S} s"),
        ),
        (
            "vehicles",
            (
                f"{toml_reading.BYTES_MAX >> 10} KiB",
                f"{toml_reading.LINE_MAX:,} characters",
                f"{toml_reading.VALUES_MAX:,} values",
                f"{reader_process.CPU_S} s",
            ),
        ),
        (
            "programs: what differs in two",
            (
                f"{source_differences.LINES_MAX:,} lines",
                f"{source_differences.BYTES_MAX >> 10} KiB",
            ),
        ),
        (
            "mapping of a log (TOML or JSON)",
            (f"{mapping.TEXT_MAX:,}", f"{log_process.CPU_S} s"),
        ),
        ("what a format is written from", (f"{conversion_process.CPU_S} s",)),
        (
            "what a client answers to nobody: silence",
            (
                f"a head {protocols.HEAD_S:g} s",
                f"connection {web_server.KEEP_ALIVE_S} s",
                f"a ping {protocols.PING_S:g} s",
                f"not taken {web_server.STALLED_S} s",
            ),
        ),
    ],
)
def test_its_limits_are_those_in_force(row: str, limits: tuple[str, ...]) -> None:
    assert [limit for limit in limits if limit not in ROWS[row]] == []
