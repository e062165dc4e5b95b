"""Messages between the simulator and a program in a box: one per packet, version 1.

A message is `<cB2xI` (type, version, two zero bytes, sequence number) and a body, little endian, on
a Unix socket of type SEQPACKET. The simulator asks; the program answers with the same sequence
number and never speaks first.

| type | direction | body |
|---|---|---|
| `I` | to the program | u32 bytes of the header, u32 bytes of the source |
| `S` | to the program | the next part of header (JSON) and source, at most 60 KiB |
| `R` | to the program | JSON: the level |
| `O` | to the program | the observation: float64 values in the order of the layout |
| `T` | to the program | an image (see shared_images.py), 8 float64: corners [px]: start tracking |
| `U` | to the program | an image: track |
| `D` | to the program | an image: detect |
| `Q` | to the program | empty: answer `q`, then exit with 0 |
| `k` | from the program | empty: ready |
| `c` | from the program | four float64: surge, sway, heave [m/s], yaw rate [rad/s] |
| `t` | from the program | 8 float64: corners [px]; empty if the target is lost |
| `d` | from the program | detections (see answers.py) |
| `x` | from the program | a letter, u16 bytes of the sentence, sentence, traceback (UTF-8) |
| `q` | from the program | empty: the last message |

`I` with all its `S` together, `R` and `T` are answered by `k`. The first `k` has sequence number 0:
the interpreter is up, no program is known yet.
"""

from seamark.sandbox.languages.inside.wire import ERROR, HEADER, VERSION
from seamark.sandbox.outcome import Failure, Verdict
from seamark.sandbox.printable_text import printable_text

BEGIN, SOURCE, RESET, OBSERVE, QUIT = b"I", b"S", b"R", b"O", b"Q"
START, UPDATE, DETECT = b"T", b"U", b"D"
READY, COMMAND, FAILED, BYE = b"k", b"c", b"x", b"q"
TRACK, DETECTIONS = b"t", b"d"

CHUNK_BYTES = 61440  # [B] of source in one message

VERDICTS = {
    b"u": Verdict.USER_ERROR,
    b"s": Verdict.COMPILE_ERROR,
    b"p": Verdict.PROTOCOL_ERROR,
    b"m": Verdict.MEMORY_LIMIT,
    b"r": Verdict.PROCESS_LIMIT,
}


class MessageInvalid(Exception):
    """The program sent something that violates the protocol. The text is for its owner."""


def message(message_type: bytes, sequence: int, body: bytes | memoryview = b"") -> bytes:
    """Return one message to the program."""
    return HEADER.pack(message_type, VERSION, sequence) + body


def check(data: bytes | memoryview, types: bytes, sequence: int) -> bytes:
    """Return the type of a message that is one of `types` and answers `sequence`."""
    if len(data) < HEADER.size:
        raise MessageInvalid(f"The program bypassed its runner and sent {len(data)} bytes.")
    message_type, version, answered = HEADER.unpack_from(data)
    if version != VERSION or message_type not in types:
        raise MessageInvalid(
            f"The program bypassed its runner and sent a message of unknown type {message_type!r}."
        )
    if answered != sequence:
        raise MessageInvalid(
            f"The program answered request {answered} when request {sequence} was pending."
        )
    return bytes(message_type)


def failure(data: bytes | memoryview) -> Failure:
    """Return the content of an error message."""
    body = bytes(data[HEADER.size :])
    if len(body) < ERROR.size:
        raise MessageInvalid("The program sent an error message that is too short.")
    letter, length = ERROR.unpack_from(body)
    verdict = VERDICTS.get(letter)
    if verdict is None or ERROR.size + length > len(body):
        raise MessageInvalid("The program sent a malformed error message.")
    text = body[ERROR.size :]
    return Failure(verdict, printable(text[:length]), printable(text[length:]))


def printable(data: bytes) -> str:
    """Return text of the program without control characters that could forge or hide lines."""
    return printable_text(data.decode("utf-8", "replace"))
