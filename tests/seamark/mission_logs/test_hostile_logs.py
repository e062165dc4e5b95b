"""Logs made to cost time or memory: each is refused with a sentence, within limits."""

import bz2
import gzip
import resource
import sqlite3
import struct
import sys
import time
import tracemalloc
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from seamark.mission_logs import csv_log, limited
from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.measuring import measure
from seamark.mission_logs.result import LogRefused

ROWS = 20_000  # 9 MB of telemetry
POSE = LogMapping.model_validate({"topics": {"pose": "/pose"}})
CYCLIC = "seamark_msgs/Cyclic me\n====\nMSG: seamark_msgs/Cyclic\nseamark_msgs/Cyclic me\n"


def _record(op: int, fields: dict[str, bytes], data: bytes) -> bytes:
    """Return a record of a ROS 1 bag."""
    named = {"op": bytes([op]), **fields}.items()
    entries = [name.encode() + b"=" + value for name, value in named]
    header = b"".join(struct.pack("<I", len(entry)) + entry for entry in entries)
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def _connection(kind: str, definition: str) -> bytes:
    text = {"topic": "/pose", "type": kind, "md5sum": "*", "message_definition": definition}
    data = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + f"{name}={value}".encode()
        for name, value in text.items()
    )
    return _record(7, {"conn": struct.pack("<I", 0), "topic": b"/pose"}, data)


def ros1_bag(
    chunk: bytes,
    *,
    compression: str = "none",
    messages: int = 1,
    kind: str = "geometry_msgs/PoseStamped",
    definition: str = "",
) -> bytes:
    """Return a ROS 1 bag of a single chunk, which says that it has some messages."""
    connection, zero = _connection(kind, definition), struct.pack("<I", 0)
    start = b"#ROSBAG V2.0\n"
    head_size = len(_record(3, _head(0), b""))
    chunk_at = len(start) + head_size
    fields = {"compression": compression.encode(), "size": struct.pack("<I", 2**32 - 1)}
    body = _record(5, fields, chunk)
    index = struct.pack("<III", 0, 0, 0) * min(messages, 3)
    body += _record(
        4, {"ver": struct.pack("<I", 1), "conn": zero, "count": struct.pack("<I", messages)}, index
    )
    index_at = chunk_at + len(body)
    info = {
        **{"ver": struct.pack("<I", 1), "chunk_pos": struct.pack("<Q", chunk_at)},
        **{"start_time": bytes(8), "end_time": bytes(8), "count": struct.pack("<I", 1)},
    }
    counts = struct.pack("<II", 0, messages)
    return start + _record(3, _head(index_at), b"") + body + connection + _record(6, info, counts)


def _head(index_at: int) -> dict[str, bytes]:
    return {
        "index_pos": struct.pack("<Q", index_at),
        "conn_count": struct.pack("<I", 1),
        "chunk_count": struct.pack("<I", 1),
    }


@pytest.fixture
def small_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits of the process that reads a log, so low that a bomb of a test exceeds them."""
    code = (
        "from seamark.mission_logs import process\n"
        "process.DATA_MIB, process.CPU_S = 700, 20\n"
        "process.main()"
    )
    monkeypatch.setattr(limited, "_COMMAND", (sys.executable, "-c", code))


@pytest.mark.slow
@pytest.mark.usefixtures("small_limits")
def test_a_chunk_that_unpacks_to_gigabytes_ends_its_own_process_only(tmp_path: Path) -> None:
    bomb = 96 * bz2.compress(bytes(2**24))  # 1.5 GiB in 5 KB
    path = tmp_path / "bomb.bag"
    path.write_bytes(ros1_bag(bomb, compression="bz2"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime

    with pytest.raises(LogRefused, match="too much time or memory"):
        limited.measure_limited(path, POSE, benchmark="currents-v1", folder=tmp_path)

    assert path.stat().st_size < 10_000
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before < 25.0


@pytest.mark.slow
def test_the_rows_of_a_long_log_are_not_in_the_memory_of_whoever_has_it_measured(
    tmp_path: Path,
) -> None:
    lines = (f"{0.05 * at:.2f},0.2,0.1,1.65,0,0,0\n" for at in range(ROWS))
    path = tmp_path / "log.csv"
    path.write_text("t,x,y,z,roll,pitch,yaw\n" + "".join(lines))
    mapping = LogMapping.model_validate({"settings": {"settle_s": 0.0}})

    tracemalloc.start()
    found = limited.measure_limited(path, mapping, benchmark="currents-v1", folder=tmp_path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert len(found.rows) == ROWS
    assert peak < found.rows.nbytes / 3


@pytest.mark.slow
def test_a_mapping_that_is_slow_to_parse_costs_whoever_has_it_measured_nothing(
    tmp_path: Path,
) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t\n0\n")
    text = "a." * 8000 + "a=1"  # quadratic in tomllib
    began = time.process_time()
    with pytest.raises(LogRefused, match=r"a: Extra inputs|neither TOML nor JSON"):
        LogMapping.parse(text)
    parsing_s = time.process_time() - began

    began = time.process_time()
    with pytest.raises(LogRefused, match=r"a: Extra inputs|neither TOML nor JSON"):
        limited.measure_limited(path, text, benchmark="", folder=tmp_path)

    assert time.process_time() - began < parsing_s / 4


@pytest.mark.slow
def test_the_benchmark_is_that_of_the_mapping_unless_another_is_named(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    lines = (f"{0.05 * at:.2f},0.2,0.1,1.65,0,0,0\n" for at in range(100))
    path.write_text("t,x,y,z,roll,pitch,yaw\n" + "".join(lines))
    text = 'benchmark = "currents-v2"\nsettings = { settle_s = 0.0 }'

    mapped = limited.measure_limited(path, text, benchmark="", folder=tmp_path)
    named = limited.measure_limited(path, text, benchmark="currents-v1", folder=tmp_path)
    with pytest.raises(LogRefused, match="not by 'no'"):
        limited.measure_limited(path, 'benchmark = "no"', benchmark="", folder=tmp_path)

    assert (mapped.benchmark, named.benchmark) == ("currents-v2", "currents-v1")


@pytest.mark.slow
def test_the_sentence_that_refuses_a_log_has_no_characters_that_act_on_a_terminal(
    tmp_path: Path,
) -> None:
    path = tmp_path / "log.csv"
    path.write_text("a\x1b]0;x\x07,b\u202e\n0,1\n")

    with pytest.raises(LogRefused, match="has no column t") as refused:
        limited.measure_limited(path, LogMapping(), benchmark="currents-v1", folder=tmp_path)

    assert str(refused.value).isprintable()


def test_a_time_beyond_all_numbers_of_control_steps_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x,y,z,roll,pitch,yaw\n0,0,0,1,0,0,0\n1e308,0,0,1,0,0,0\n")
    mapping = LogMapping.model_validate({"time": {"period_s": 0.01, "max_gap_s": 1.0}})

    with pytest.raises(LogRefused, match="it may have 500000"):
        measure(path, mapping, benchmark="currents-v1")


def test_a_level_in_several_pieces_is_refused(tmp_path: Path) -> None:
    lines = (f"{0.05 * at},0,0,1,0,0,0,{at % 2}\n" for at in range(40))
    path = tmp_path / "log.csv"
    path.write_text("t,x,y,z,roll,pitch,yaw,level\n" + "".join(lines))
    mapping = LogMapping.model_validate({"settings": {"settle_s": 0.0, "levels": [0.1, 0.2]}})

    with pytest.raises(LogRefused, match="level 0 is in several pieces"):
        measure(path, mapping, benchmark="currents-v1")


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (b"\x89MCAP0\r\n" + b"\xff" * 64, "log.mcap"),  # an opcode and a length that do not exist
        (b"\x89MCAP1\r\n" + bytes(64), "log.mcap"),
        (b"#ROSBAG V1.2\n" + bytes(64), "log.bag"),
        (b"#ROSBAG V2.0\n" + b"\xff" * 64, "log.bag"),  # a header of 4 GiB
        (ros1_bag(b"", messages=2**32 - 1), "log.bag"),  # more messages than bytes
        (ros1_bag(bytes(16)), "log.bag"),
        (ros1_bag(b"", compression="rot13"), "log.bag"),
        (b"SQLite format 3\x00" + bytes(200), "log.db3"),
    ],
    ids=("mcap", "no mcap", "old bag", "header", "count", "zeros", "compression", "database"),
)
def test_a_damaged_bag_is_refused_before_anything_is_allocated(
    tmp_path: Path, content: bytes, name: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content)

    with pytest.raises(LogRefused, match=r"The file cannot be read|has no messages"):
        measure(path, POSE, benchmark="currents-v1")


def test_a_refusal_does_not_tell_where_a_server_keeps_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.db3"
    with closing(sqlite3.connect(path)) as database:
        database.execute("CREATE VIEW messages AS SELECT 1 id, zeroblob(1000000000) data")

    with pytest.raises(LogRefused, match="cannot be read") as refused:
        measure(path, POSE, benchmark="currents-v1")

    assert str(tmp_path) not in str(refused.value)


def test_a_definition_that_holds_itself_is_never_parsed(tmp_path: Path) -> None:
    path = tmp_path / "log.bag"
    path.write_bytes(ros1_bag(b"", kind="seamark_msgs/Cyclic", definition=CYCLIC))

    with pytest.raises(LogRefused, match="seamark_msgs/msg/Cyclic, which is not read"):
        measure(path, POSE, benchmark="currents-v1")


@pytest.mark.parametrize(
    ("write", "sentence"),
    [
        (lambda: b"t,x\n" + b"0,1\n" * 51, "more than 50 rows"),
        (lambda: b"t,x\n" + b"#\n\n" * 800, "more than 1500 lines"),
        (lambda: b"t" * 70_000, "Line 1 is longer than 65536 characters"),
        (lambda: b"#\n" * 2000, "no line with the names"),
        (lambda: b",".join([b"x"] * 2000) + b"\n", "2000 columns"),
        (lambda: b"t,x\n0,\xff\n", "not text in UTF-8"),
        (lambda: gzip.compress(b"t" * 70_000), "Line 1 is longer"),
        (lambda: gzip.compress(b"t,x\n0,1\n")[:-6], "compressed file is damaged"),
        (lambda: b"t,x\n0,1e999\n", "x is infinite"),
        (lambda: b't,x\n0,"\n', "x is missing or nan"),
    ],
)
def test_a_csv_of_any_size_is_refused_at_the_first_line_beyond_a_limit(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    write: Callable[[], bytes],
    sentence: str,
) -> None:
    monkeypatch.setattr(csv_log, "ROWS_MAX", 50)
    monkeypatch.setattr(csv_log, "LINES_MAX", 1500)
    content = write()
    path = tmp_path / ("log.csv.gz" if content[:2] == b"\x1f\x8b" else "log.csv")
    path.write_bytes(content)

    with pytest.raises(LogRefused, match=sentence):
        measure(path, LogMapping(), benchmark="currents-v1")
