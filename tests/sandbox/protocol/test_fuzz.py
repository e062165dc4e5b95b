"""Both sides of the protocol take whatever is sent: a verdict or a sentence, never a crash."""

import random
import struct

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from seamark.sandbox.outcome import Verdict
from seamark.sandbox.protocol import messages
from tests.fuzz import sides
from tests.fuzz.session import packets_of, runner_once, trusted_once

KINDS = [bytes([letter]) for letter in b"kcxqtdISROTUDQ\x00\xff"]
NUMBERS = st.one_of(st.integers(0, 8), st.integers(0, 2**32 - 1))
DOUBLES = st.lists(st.floats(), max_size=12).map(lambda many: struct.pack(f"<{len(many)}d", *many))
BODIES = st.one_of(st.binary(max_size=200), DOUBLES, st.just(b""), st.just(bytes(70_000)))
FRAMES = st.builds(
    lambda kind, version, number, body: struct.pack("<cB2xI", kind, version, number) + body,
    st.sampled_from(KINDS),
    st.sampled_from([1, 1, 1, 0, 2, 255]),
    NUMBERS,
    BODIES,
)
PACKETS = st.lists(st.one_of(FRAMES, st.binary(max_size=80)), max_size=8)

WELL = [
    messages.frame(messages.READY, 0),
    messages.frame(messages.READY, 1),
    messages.COMMAND.pack(messages.ANSWER, 1, 2, 1.0, 2.0, 3.0, 4.0),
    messages.frame(messages.TRACK, 3, struct.pack("<8d", *range(8))),
    messages.frame(messages.DETECTIONS, 4, struct.pack("<I9dH", 1, *[0.5] * 9, 2) + b"ab"),
    messages.frame(messages.BYE, 5),
]
SEEDS = range(300)


def test_an_error_is_heard_also_if_the_program_left_before_it_was_asked_everything() -> None:
    said = messages.ERROR.pack(b"s", 5) + b"wrong"

    assert (
        sides.trusted([WELL[0], messages.frame(messages.FAILED, 1, said)]) is Verdict.COMPILE_ERROR
    )


def test_the_peer_of_this_file_reaches_every_question() -> None:
    with_code = sides.trusted(WELL)

    assert with_code is Verdict.PROTOCOL_ERROR  # the last word came, exit code 0 did not
    assert sides.trusted(WELL[:-1]) is Verdict.PROTOCOL_ERROR


@settings(max_examples=150, deadline=None)
@given(packets=PACKETS, printed=st.binary(max_size=100))
def test_whatever_a_program_sends_it_ends_as_a_verdict(packets, printed) -> None:
    sides.trusted(packets, printed)


@settings(max_examples=150, deadline=None)
@given(data=st.data(), packets=PACKETS)
@example(data=None, packets=[])
def test_a_good_program_that_turns_bad_at_any_point_ends_as_a_verdict(data, packets) -> None:
    good = 0 if data is None else data.draw(st.integers(0, len(WELL)))

    sides.trusted([*WELL[:good], *packets])


@settings(max_examples=40, deadline=None)
@given(packets=PACKETS)
def test_whatever_the_runner_is_sent_it_ends_by_itself(packets) -> None:
    code, _ = sides.runner(packets)

    assert code in sides.GOOD_EXITS


@settings(max_examples=40, deadline=None)
@given(packets=PACKETS)
def test_whatever_the_runner_is_sent_after_a_program_it_ends_by_itself(packets) -> None:
    code, kinds = sides.runner([*sides.loading(), *packets])

    assert code in sides.GOOD_EXITS
    assert kinds[:2] == [b"k", b"k"]
    assert set(kinds) <= {b"k", b"c", b"x", b"q"}


def test_the_runner_of_this_file_answers_what_is_well() -> None:
    asked = [
        *sides.loading(),
        messages.frame(messages.RESET, 3, b"{}"),
        messages.frame(messages.OBSERVE, 4, struct.pack("<4d", 1.0, 2.0, 3.0, 4.0)),
        messages.frame(messages.QUIT, 5),
    ]

    assert sides.runner(asked) == (0, [b"k", b"k", b"k", b"c", b"q"])


@pytest.mark.parametrize("once", [trusted_once, runner_once])
def test_the_targets_of_the_fuzzer_take_a_corpus_of_random_bytes(once) -> None:
    for seed in SEEDS:
        once(random.Random(seed).randbytes(seed * 3))  # noqa: S311


def test_the_fuzzers_bytes_become_frames_of_all_shapes() -> None:
    made = packets_of(b"\x01\x00\x02c!" + b"\x02\x00\x01cab")

    assert made == [messages.frame(b"c", 1, b"!"), b"ab"]
