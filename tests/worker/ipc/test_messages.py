"""Messages across a real socket: each type arrives as it was sent."""

import socket
from collections.abc import Iterator

import numpy as np
import pytest

from seamark.programs.failure_reasons import FailureReason
from seamark.sandbox.outcome import Outcome, Verdict
from seamark.sim.recording.telemetry import WIDTH
from seamark.worker.ipc import messages
from seamark.worker.ipc.listener import deliver
from seamark.worker.ipc.messages import (
    BoxFailed,
    Crashed,
    Log,
    Message,
    Reader,
    Rows,
    RunEnded,
    Started,
    StreamBroken,
    TrialEnded,
    TrialReport,
    TrialRestarted,
)
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome
from tests.worker.evaluation.fakes import FakeListener

FAILED = RunOutcome(
    failure=FailureReason.TIME_LIMIT,
    sentence="too slow",
    traceback="line 5",
    usage={"cpu_s": 0.1},
    metrics={"score": 1.0 / 3.0, "trials": [{"trial": 0}]},
    manifest={"digest": "d"},
    digest="d",
)
TRIAL = TrialOutcome(program=Outcome(verdict=Verdict.USER_ERROR, sentence="1 / 0"))


@pytest.fixture
def channel() -> Iterator[tuple[socket.socket, socket.socket]]:
    mine, theirs = socket.socketpair()
    with mine, theirs:
        yield mine, theirs


def received(channel: tuple[socket.socket, socket.socket], *sent: Message) -> list[Message]:
    mine, theirs = channel
    for message in sent:
        messages.send(theirs, message)
    return list(Reader(mine).read(1.0))


def test_each_type_of_message_arrives_in_order_as_it_was_sent(channel) -> None:
    sent = [
        Started(7),
        Log(b"\xff\n"),
        TrialEnded(1),
        TrialRestarted(2, "the host was slow"),
        BoxFailed("no room"),
        RunEnded(RunOutcome()),
        RunEnded(FAILED),
        Crashed("Traceback"),
    ]

    assert received(channel, *sent) == sent


def test_telemetry_arrives_bit_for_bit(channel) -> None:
    rows = np.random.default_rng(1).standard_normal((60, WIDTH))
    rows[3, 4] = np.nan

    [message] = received(channel, Rows(rows[::2]))

    assert isinstance(message, Rows)
    assert message.rows.tobytes() == np.ascontiguousarray(rows[::2]).tobytes()


def test_the_outcome_of_a_trial_arrives_as_it_was_reported(channel) -> None:
    [message] = received(channel, TrialReport.of(TRIAL))

    assert isinstance(message, TrialReport)
    assert message.outcome() == TRIAL


def test_a_message_that_comes_in_pieces_is_read_when_it_is_whole(channel) -> None:
    mine, theirs = channel
    whole, other = socket.socketpair()
    with whole, other:
        messages.send(other, Log(b"x" * 5000))
        data = whole.recv(10_000)
    reader = Reader(mine)

    theirs.sendall(data[:3000])
    first = list(reader.read(1.0))
    theirs.sendall(data[3000:])

    assert first == []
    assert list(reader.read(1.0)) == [Log(b"x" * 5000)]


@pytest.mark.parametrize("data", [b"?\0\0\0\0", b"L\xff\xff\xff\xff"], ids=["type", "length"])
def test_bytes_that_are_no_message_are_a_failure_of_the_platform(channel, data: bytes) -> None:
    mine, theirs = channel
    theirs.sendall(data)

    with pytest.raises(StreamBroken):
        list(Reader(mine).read(1.0))


def test_a_message_that_no_sender_sends_is_a_failure_of_the_platform() -> None:
    with pytest.raises(StreamBroken, match="Crashed"):
        deliver(Crashed("Traceback"), FakeListener())
