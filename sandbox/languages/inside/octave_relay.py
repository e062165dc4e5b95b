"""Passes on what the trusted side asks of GNU Octave, and what that answers.

Started by runner.m with two pipes as standard input and output. Arguments: `--` and the numbers of
the connection.

To Octave goes one float64 with the size of a text in its own language (what the configuration is
and how an observation is made of numbers) and that text; then, for each question, one float64 with
the kind and as many as an observation has; a level is the size of a text and the text once more. A
question with an image has height, width, channels and corners in the place of an observation, then
the image's bytes: Octave cannot map memory.
From Octave come five float64: a command, or an error with the sizes of its two texts, or how many
float64 follow: corners, or what a detector found.
"""

import io
import json
import mmap
import os
import re
import struct
import sys
import zipfile
from typing import Any, NoReturn

from .connection import COMMAND, Connection, connected
from .octave import FOLDER, PLACED

ARCHIVE, MAIN = b"PK\x03\x04", "controller.m"
NUMBER = struct.Struct("<d")
ANSWER = struct.Struct("<5d")
READY, FAILED, TRACK, DETECTIONS = map(ord, "kxtd")
PICTURE = struct.Struct("<4I")  # offset [B], height, width [px], channels
SHOWN = 11  # float64 of a question with an image: height, width, channels, corners
CORNERS = 8
DETECTION = struct.Struct("<9dH")  # corners, confidence, bytes of the label that follows
MOST_NUMBERS = 64 * (CORNERS + 2 + 64)  # of an answer: 64 detections with labels of 64 bytes
NAME = re.compile(r"[A-Za-z]\w{0,62}", re.ASCII)  # what may be the name of a field


def relay(connection: Connection) -> NoReturn:
    """Pass questions on to Octave and its answers back."""
    connection.send(b"k")
    header, source = connection.program()
    names = _placed(str(header["filename"]), source)
    images = _mapped(connection, header)
    observation = header["layout"].get("observation", ())
    floats = sum(count or 1 for _, count in observation) if images is None else SHOWN
    _tell(octave_begin(header, names, floats))
    _answer(connection)
    while True:
        kind, body = connection.receive()
        if kind == b"O":
            _write(NUMBER.pack(ord("O")) + body)
        elif kind in b"TUD" and images is not None:
            _show(kind, body, images)
        elif kind == b"R":
            text = f"level = {octave_value(json.loads(body))};".encode()
            padding = bytes(NUMBER.size * (floats - 1))
            _write(NUMBER.pack(ord("R")) + NUMBER.pack(len(text)) + padding + text)
        else:
            _write(NUMBER.pack(ord("Q")) + bytes(NUMBER.size * floats))
            _read(ANSWER.size)  # Octave has printed all it had to print
            connection.leave()
        _answer(connection)


def _mapped(connection: Connection, header: dict[str, Any]) -> mmap.mmap | None:
    """Return the memory of the images; None for a controller, which has none."""
    described = header.get("images")
    if described is None:
        connection.close_others()
        return None
    descriptor = described["descriptor"]
    connection.close_others(descriptor)
    memory = mmap.mmap(descriptor, described["bytes"], prot=mmap.PROT_READ)
    os.close(descriptor)
    return memory


def _show(kind: bytes, body: bytes, images: mmap.mmap) -> None:
    """Pass on a question with its image."""
    offset, *shape = PICTURE.unpack_from(body)
    corners = body[PICTURE.size :].ljust(CORNERS * NUMBER.size, b"\0")
    _write(NUMBER.pack(ord(kind)) + struct.pack("<3d", *shape) + corners)
    height, width, channels = shape
    with memoryview(images) as memory:
        _write(memory[offset : offset + height * width * channels])


def _placed(filename: str, source: bytes) -> tuple[str, str]:
    """Write the program, or the files of an archive, where Octave reads them.

    Return what its author calls the main one, and what it is called here. It gets a line before
    its first, which makes it a file of functions.
    """
    placed = PLACED
    if source.startswith(ARCHIVE):
        with zipfile.ZipFile(io.BytesIO(source)) as archive:
            archive.extractall(FOLDER)
        filename = placed = MAIN
        source = (FOLDER / MAIN).read_bytes()
    (FOLDER / placed).write_bytes(b"1;\n" + source)
    return filename, placed


def octave_begin(header: dict[str, Any], names: tuple[str, str], floats: int) -> str:
    """Return what runner.m has to know, as text in its language."""
    layout = header["layout"]
    booleans = set(layout.get("booleans", ()))
    fields, at = [], 1
    for name, count in layout.get("observation", ()):
        taken = f"v({at}:{at + count - 1})" if count else f"v({at})"
        fields.append(f"'{name}', {taken}{' != 0' if name in booleans else ''}")
        at += count or 1
    return (
        f"filename = {octave_value(names[0])};\n"
        f"placed = {octave_value(names[1])};\n"
        f"role = {octave_value(layout.get('role', 'controller'))};\n"
        f"floats = {floats};\n"
        f"config = {octave_value(header['config'])};\n"
        f"observe = @(v) struct({', '.join(fields)});\n"
    )


def octave_value(value: object) -> str:
    """Return a JSON value as text in Octave's language; numbers come out the same to the last bit.

    Lists of numbers are rows, other lists are cells; an object is a structure of those of its keys
    that can be names.
    """
    if value is None:
        return "[]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(float(value))
    if isinstance(value, str):
        return '"' + "".join(f"\\{byte:03o}" for byte in value.encode("utf-8")) + '"'
    if isinstance(value, list):
        plain = all(isinstance(item, (int, float)) for item in value)
        words = ", ".join(octave_value(item) for item in value)
        return f"[{words}]" if plain else f"{{{words}}}"
    if isinstance(value, dict):
        # In braces: a cell as a value of struct() would make an array of structures.
        named = [(key, octave_value(item)) for key, item in value.items() if NAME.fullmatch(key)]
        return "struct(" + ", ".join(f"'{key}', {{{item}}}" for key, item in named) + ")"
    raise TypeError(f"JSON has no {type(value).__name__}")


def _tell(text: str) -> None:
    data = text.encode()
    _write(NUMBER.pack(len(data)) + data)


def _answer(connection: Connection) -> None:
    """Pass one answer of Octave on."""
    kind, *numbers = ANSWER.unpack(_read(ANSWER.size))
    if kind == READY:
        connection.send(b"k")
    elif kind == FAILED:
        letter, sentence, text = (int(number) for number in numbers[:3])
        words = _read(sentence).decode("utf-8", "replace")
        connection.give_up(bytes([letter]), words, _read(text).decode("utf-8", "replace"))
    elif kind in (TRACK, DETECTIONS):
        count = min(int(numbers[0]), MOST_NUMBERS)
        more = struct.unpack(f"<{count}d", _read(NUMBER.size * count))
        body = struct.pack(f"<{count}d", *more) if kind == TRACK else _found(more)
        connection.send(bytes([int(kind)]), body)
    else:
        connection.send(b"c", COMMAND.pack(*numbers))


def _found(numbers: tuple[float, ...]) -> bytes:
    """Return detections as a frame has them."""
    parts, at = [], 0
    while at < len(numbers):
        label = at + CORNERS + 2
        size = int(numbers[label - 1])
        text = bytes(int(code) & 255 for code in numbers[label : label + size])
        parts.append(DETECTION.pack(*numbers[at : label - 1], size) + text)
        at = label + size
    return struct.pack("<I", len(parts)) + b"".join(parts)


def _write(data: bytes | memoryview) -> None:
    while data:
        data = data[os.write(1, data) :]


def _read(size: int) -> bytes:
    """Return what Octave wrote; ends the process if Octave is gone."""
    data = b""
    while len(data) < size:
        part = os.read(0, size - len(data))
        if not part:
            os._exit(0)
        data += part
    return data


def main() -> None:
    """Relay until the end."""
    split = sys.argv.index("--")
    relay(connected(sys.argv[split + 1 :], images=True))
