"""The file of a record says exactly what a run gets, and nothing else is taken."""

import hashlib
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.record import (
    BYTES_MAX,
    FIRST_LINE,
    RecordInvalid,
    read_record,
    write_record,
)
from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid

HEAD = f"{FIRST_LINE}\n# title: A test\ntime_s,height_m,north,east,down\n"


def body(count: int = 10) -> str:
    return "".join(f"{60 * i},{h},{0.1 * h},{0.01 * i},0\n" for i in range(count) for h in (1, 2))


def test_a_written_record_is_read_again() -> None:
    record = read_record((HEAD + body()).encode())

    again = read_record(write_record(record))

    assert (again.step_s, again.notes, again.title) == (60.0, {"title": "A test"}, "A test")
    assert again.heights.tolist() == [1.0, 2.0]
    np.testing.assert_array_equal(again.velocity, record.velocity)
    assert again.duration_s == 540.0


def test_shipped_records_are_read_and_say_what_they_are() -> None:
    assert records.SHIPPED
    for name in records.SHIPPED:
        record = records.load(name)
        assert "licence" in record.notes
        assert record.strongest_mean(120.0) > 0.1
        assert "synthetic" not in name or "not measured" in record.title


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", "begins with"),
        ("time,u,v\n", "begins with"),
        (FIRST_LINE, "has the line"),
        (HEAD, "no rows"),
        (HEAD + "0,1,0,0\n", "five numbers"),
        (HEAD + "0,1,0,0,nan\n", "five numbers"),
        (HEAD + body(3), "8 to"),
        (HEAD + body() + "600,1,0,0,0\n", "the same heights"),
        (HEAD + body().replace(",2,", ",1,"), "must increase"),
        (HEAD + body().replace("\n120,", "\n130,"), "equal steps"),
        (HEAD + body().replace(",0.2,", ",20,"), "m/s"),
        (HEAD + "".join(f"{i},1,0,0,0\n" for i in range(9)), "still"),
        (HEAD + "x" * BYTES_MAX, "bytes"),
    ],
)
def test_what_is_no_record_is_refused_with_a_sentence(content: str, sentence: str) -> None:
    with pytest.raises(RecordInvalid, match=sentence):
        read_record(content.encode())


@given(st.binary(max_size=300))
def test_any_bytes_are_a_record_or_refused(content: bytes) -> None:
    with pytest.raises(RecordInvalid):
        read_record(HEAD.encode() + content)


def test_a_users_record_is_known_by_its_digest_alone() -> None:
    content = (HEAD + body()).encode()
    assert not records.LIBRARY.is_known("record@0123456789abcdef")

    name = records.LIBRARY.add(content)

    assert records.LIBRARY.is_own(name)
    assert records.LIBRARY.is_known(name)
    assert records.load(name).title == "A test"
    file = records.LIBRARY.file_of(name)
    assert file is not None
    assert file.text.encode() == content
    assert file.sha256.startswith(name.partition("@")[2])


def test_a_lent_record_is_known_to_this_thread_and_only_meanwhile() -> None:
    content = (HEAD.replace("A test", "Lent") + body()).encode()
    with ThreadPoolExecutor(1) as other, records.LIBRARY.lending(content) as name:
        assert records.LIBRARY.is_known(name)
        assert records.load(name).title == "Lent"
        assert records.LIBRARY.file_of(name) == (
            hashlib.sha256(content).hexdigest(),
            content.decode(),
        )
        assert not other.submit(records.LIBRARY.is_known, name).result()

    assert not records.LIBRARY.is_known(name)
    assert records.LIBRARY.file_of(name) is None
    with pytest.raises(LookupError):
        records.load(name)


def test_a_benchmark_takes_a_lent_record_and_refuses_it_afterwards() -> None:
    with records.LIBRARY.lending((HEAD + body()).encode().replace(b"A test", b"Taken")) as name:
        assert benchmark("currents-v2").read({"current_record": name})
    with pytest.raises(ConfigurationInvalid, match="current_record"):
        benchmark("currents-v2").read({"current_record": name})
