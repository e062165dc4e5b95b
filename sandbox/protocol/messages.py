"""The protocol between a box and its program: one frame per packet, version 1.

A frame is `<cB2xI` (kind, version, two zero bytes, sequence number) and a body, little endian,
on a Unix socket of type SEQPACKET. The trusted side asks, the program answers with the same
sequence number; it never speaks first.

| kind | way | body |
|---|---|---|
| `I` | to the program | u32 bytes of the header, u32 bytes of the source |
| `S` | to the program | the next part of header (JSON) and source, at most 60 KiB |
| `R` | to the program | JSON: the level |
| `O` | to the program | the observation: float64 values in the order of the layout |
| `T` | to the program | an image (see pictures.py), 8 float64: corners [px]: start to track |
| `U` | to the program | an image: track |
| `D` | to the program | an image: detect |
| `Q` | to the program | nothing: answer `q`, then exit with 0 |
| `k` | from the program | nothing: ready |
| `c` | from the program | four float64: surge, sway, heave [m/s], yaw rate [rad/s] |
| `t` | from the program | 8 float64: corners [px]; nothing if the target is lost |
| `d` | from the program | detections (see answers.py) |
| `x` | from the program | a letter, u16 bytes of the sentence, sentence, traceback (UTF-8) |
| `q` | from the program | nothing: the last word |

`I`, all `S` together, `R` and `T` are answered by `k`. The first `k` has sequence number 0: the
interpreter is up, no program is known yet. The runner inside (languages/python_inside) has the
same numbers once more: it can import nothing of ours.
"""

import struct
from dataclasses import dataclass

from seamark.sandbox.outcome import Verdict

VERSION = 1
HEADER = struct.Struct("<cB2xI")
COMMAND = struct.Struct("<cB2xI4d")
SIZES = struct.Struct("<II")
ERROR = struct.Struct("<cH")

BEGIN, SOURCE, RESET, OBSERVE, QUIT = b"I", b"S", b"R", b"O", b"Q"
START, UPDATE, DETECT = b"T", b"U", b"D"
READY, ANSWER, FAILED, BYE = b"k", b"c", b"x", b"q"
TRACK, DETECTIONS = b"t", b"d"

MOST_BYTES = 65536  # [B] a frame of the program; the longest is an error with its traceback
CHUNK_BYTES = 61440  # [B] of source in one frame

VERDICTS = {
    b"u": Verdict.USER_ERROR,
    b"s": Verdict.COMPILE_ERROR,
    b"p": Verdict.PROTOCOL_ERROR,
    b"m": Verdict.MEMORY_LIMIT,
    b"r": Verdict.PROCESS_LIMIT,
}


class FrameInvalid(Exception):
    """The program sent something that is not in the protocol. The text is for its owner."""


@dataclass(frozen=True, slots=True)
class Failure:
    """What the runner inside says about the end of the program. Not to be trusted, only shown."""

    verdict: Verdict
    sentence: str
    traceback: str


def frame(kind: bytes, sequence: int, body: bytes | memoryview = b"") -> bytes:
    """Return one frame to the program."""
    return HEADER.pack(kind, VERSION, sequence) + body


def check(data: bytes | memoryview, kinds: bytes, sequence: int) -> bytes:
    """Return the kind of a frame that is one of `kinds` and answers `sequence`."""
    if len(data) < HEADER.size:
        raise FrameInvalid(f"The program sent a frame of {len(data)} bytes past its runner.")
    kind, version, answered = HEADER.unpack_from(data)
    if version != VERSION or kind not in kinds:
        raise FrameInvalid(f"The program sent a frame of unknown kind {kind!r} past its runner.")
    if answered != sequence:
        raise FrameInvalid(
            f"The program answered question {answered} when question {sequence} was asked."
        )
    return bytes(kind)


def failure(data: bytes | memoryview) -> Failure:
    """Return what an error frame says."""
    body = bytes(data[HEADER.size :])
    if len(body) < ERROR.size:
        raise FrameInvalid("The program sent an error frame that is too short.")
    kind, length = ERROR.unpack_from(body)
    verdict = VERDICTS.get(kind)
    if verdict is None or ERROR.size + length > len(body):
        raise FrameInvalid("The program sent an error frame that is wrong inside.")
    text = body[ERROR.size :]
    return Failure(verdict, readable(text[:length]), readable(text[length:]))


def readable(data: bytes) -> str:
    """Return text of the program without control characters that could forge or hide lines."""
    text = data.decode("utf-8", "replace")
    return "".join(c if c.isprintable() or c in "\n\t" else f"\\x{ord(c):02x}" for c in text)
