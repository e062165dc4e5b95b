"""Both ends of the protocol accept whatever is sent: a verdict or an error, never a crash."""

import random
import struct

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from seamark.sandbox.languages.inside.wire import ERROR
from seamark.sandbox.outcome import Verdict
from seamark.sandbox.protocol import messages
from tests.fuzz import sides
from tests.fuzz.session import packets_of, runner_once, simulator_once

TYPES = [bytes([letter]) for letter in b"kcxqtdISROTUDQ\x00\xff"]
NUMBERS = st.one_of(st.integers(0, 8), st.integers(0, 2**32 - 1))
DOUBLES = st.lists(st.floats(), max_size=12).map(lambda many: struct.pack(f"<{len(many)}d", *many))
BODIES = st.one_of(st.binary(max_size=200), DOUBLES, st.just(b""), st.just(bytes(70_000)))
MESSAGES = st.builds(
    lambda letter, version, number, body: struct.pack("<cB2xI", letter, version, number) + body,
    st.sampled_from(TYPES),
    st.sampled_from([1, 1, 1, 0, 2, 255]),
    NUMBERS,
    BODIES,
)
PACKETS = st.lists(st.one_of(MESSAGES, st.binary(max_size=80)), max_size=8)

WELL = [
    messages.message(messages.READY, 0),
    messages.message(messages.READY, 1),
    messages.message(messages.COMMAND, 2, struct.pack("<4d", 1.0, 2.0, 3.0, 4.0)),
    messages.message(messages.TRACK, 3, struct.pack("<8d", *range(8))),
    messages.message(messages.DETECTIONS, 4, struct.pack("<I9dH", 1, *[0.5] * 9, 2) + b"ab"),
    messages.message(messages.BYE, 5),
]
SEEDS = range(300)


def test_an_error_is_reported_even_if_the_program_left_before_the_next_request() -> None:
    error = ERROR.pack(b"s", 5) + b"wrong"

    assert (
        sides.simulator([WELL[0], messages.message(messages.FAILED, 1, error)])
        is Verdict.COMPILE_ERROR
    )


def test_the_good_messages_of_this_file_reach_every_request() -> None:
    with_code = sides.simulator(WELL)

    assert with_code is Verdict.PROTOCOL_ERROR  # it quit, but not with exit code 0
    assert sides.simulator(WELL[:-1]) is Verdict.PROTOCOL_ERROR


@settings(max_examples=150, deadline=None)
@given(packets=PACKETS, printed=st.binary(max_size=100))
def test_whatever_a_program_sends_it_ends_with_a_verdict(packets, printed) -> None:
    sides.simulator(packets, printed)


@settings(max_examples=150, deadline=None)
@given(data=st.data(), packets=PACKETS)
@example(data=None, packets=[])
def test_a_good_program_that_turns_bad_at_any_point_ends_with_a_verdict(data, packets) -> None:
    good = 0 if data is None else data.draw(st.integers(0, len(WELL)))

    sides.simulator([*WELL[:good], *packets])


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(packets=PACKETS)
def test_whatever_the_runner_receives_it_exits(packets) -> None:
    code, _ = sides.runner(packets)

    assert code in sides.GOOD_EXITS


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(packets=PACKETS)
def test_whatever_the_runner_receives_after_a_program_it_exits(packets) -> None:
    code, types = sides.runner([*sides.loading(), *packets])

    assert code in sides.GOOD_EXITS
    assert types[:2] == [b"k", b"k"]
    assert set(types) <= {b"k", b"c", b"x", b"q"}


def test_the_runner_answers_good_requests() -> None:
    asked = [
        *sides.loading(),
        messages.message(messages.RESET, 3, b"{}"),
        messages.message(messages.OBSERVE, 4, struct.pack("<4d", 1.0, 2.0, 3.0, 4.0)),
        messages.message(messages.QUIT, 5),
    ]

    assert sides.runner(asked) == (0, [b"k", b"k", b"k", b"c", b"q"])


@pytest.mark.parametrize("once", [simulator_once, runner_once])
def test_the_fuzz_targets_accept_random_bytes(once) -> None:
    for seed in SEEDS:
        once(random.Random(seed).randbytes(seed * 3))  # noqa: S311


def test_the_fuzzers_bytes_become_messages_and_raw_packets() -> None:
    made = packets_of(b"\x01\x00\x02c!" + b"\x02\x00\x01cab")

    assert made == [messages.message(b"c", 1, b"!"), b"ab"]
