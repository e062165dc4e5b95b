"""The rows in Seamark's own MCAP files: messages `seamark_msgs/msg/Telemetry` of one topic."""

from __future__ import annotations

import struct
from collections.abc import Iterable

import numpy as np

from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import ROWS_MAX, Samples
from seamark.sim.recording import telemetry

TOPIC, TYPE = "/telemetry", "seamark_msgs/msg/Telemetry"
_LITTLE_ENDIAN = b"\x00\x01"  # how a message of CDR begins
_HEAD_BYTES = 4
_FRAME_AT = 8  # length of the name of the frame, after the stamp
_THRUSTERS_MAX = 32
_ARMS = ((False, False), (True, False), (True, True))  # without one, with one, and at work
_WIDTHS = frozenset(
    telemetry.width_for(thrusters, arm=arm, work=work, detections=detections)
    for thrusters in range(_THRUSTERS_MAX + 1)
    for arm, work in _ARMS
    for detections in (False, True)
)


def read(messages: Iterable[bytes]) -> list[Samples]:
    """Return the rows of the messages, whose columns follow from their length.

    Raises
    ------
    LogRefused
        A message is no row of telemetry.
    """
    rows: list[telemetry.Rows] = []
    for number, data in enumerate(messages, start=1):
        if number > ROWS_MAX:
            raise LogRefused(f"{TOPIC} has more than {ROWS_MAX} messages. Cut the log into parts.")
        rows.append(_row(data, number))
        if len(rows[-1]) != len(rows[0]):
            raise LogRefused(f"Message {number} of {TOPIC} has other columns than the first.")
    if not rows:
        raise LogRefused(f"{TOPIC} has no messages.")
    whole = np.stack(rows)
    values = dict(zip(telemetry.names(whole.shape[1]), whole.T, strict=True))
    del values["step_us"]
    stamps = values.pop("t")
    numbers = np.arange(1, len(whole) + 1)
    return [Samples(label=TOPIC, noun="message", stamps=stamps, numbers=numbers, values=values)]


def _row(data: bytes, number: int) -> telemetry.Rows:
    """Return the doubles behind the header of a message."""
    body = bytes(data[_HEAD_BYTES:])
    if bytes(data[:2]) != _LITTLE_ENDIAN or len(body) < _FRAME_AT + 4:
        raise LogRefused(f"Message {number} of {TOPIC} is damaged.")
    (length,) = struct.unpack_from("<I", body, _FRAME_AT)
    start = -(-(_FRAME_AT + 4 + length) // 8) * 8  # doubles are aligned
    count, rest = divmod(len(body) - start, 8)
    if rest or count not in _WIDTHS:
        raise LogRefused(f"Message {number} of {TOPIC} is no row of telemetry.")
    return np.frombuffer(body, "<f8", offset=start)
