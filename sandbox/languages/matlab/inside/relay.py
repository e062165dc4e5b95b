"""Relays the simulator's requests to GNU Octave, and Octave's answers back.

Started by runner.m with two pipes as standard input and output. Arguments: `--`, then those of
`connected`.

Octave first receives a text in its own language (the configuration, and how to make an observation
of numbers): its size as one float64, then the text. Then, for each request, one float64 with the
message type and as many as an observation has. A level is the size of a text, then the text. A
request with an image has height, width, channels and corners instead of an observation, then the
image's bytes: Octave cannot map memory. The observation of a controller that gets images ends with
1 if the bytes of new ones follow, of one camera after the other, else with 0.
Octave answers with five float64: a command, of which the speeds of an arm's joints follow; or an
error with the sizes of its two texts; or the number of float64 that follow: corners or detections.
"""

import json
import mmap
import os
import re
import struct
import sys

from ...inside.connection import Connection, connected
from ...inside.wire import (
    COUNT,
    DETECTION,
    IMAGE,
    MAX_DETECTIONS,
    MAX_LABEL_BYTES,
    command_limits,
    command_names,
)
from .octave import FOLDER, PROGRAM_FILE

TYPE_CHECKING = False  # `typing` takes a millisecond of every start
if TYPE_CHECKING:
    from typing import Any, NoReturn

ZIP_MAGIC = b"PK\x03\x04"
MAINS = ("controller.m", "tracker.m", "detector.m")  # the first that is there is the program
NUMBER = struct.Struct("<d")
ANSWER = struct.Struct("<5d")
READY, FAILED, TRACK, DETECTIONS = map(ord, "kxtd")
IMAGE_REQUEST_FLOATS = 11  # height, width, channels, corners
CORNERS = 8
MAX_ANSWER_FLOATS = MAX_DETECTIONS * (CORNERS + 2 + MAX_LABEL_BYTES)
NAME = re.compile(r"[A-Za-z]\w{0,62}", re.ASCII)  # a valid name of a field


def relay(connection: Connection) -> "NoReturn":
    """Relay requests and answers until the end."""
    connection.send(b"k")
    header, source = connection.program()
    names = _write_program(str(header["filename"]), source)
    images = _mapped(connection, header)
    observation = header["layout"].get("observation", ())
    cameras, seen = len(header["layout"].get("images", ())), b""
    floats = sum(count or 1 for _, count in observation) + bool(cameras) or IMAGE_REQUEST_FLOATS
    _send_text(octave_setup(header, names, floats))
    joints = len(command_names(header["layout"])) - 4
    _relay_answer(connection, joints)
    while True:
        message_type, body = connection.receive()
        if message_type == b"O" and images is not None:
            seen = _relay_observation(body, cameras, images, seen)
        elif message_type == b"O":
            _write(NUMBER.pack(ord("O")) + body)
        elif message_type in b"TUD" and images is not None:
            _relay_image(message_type, body, images)
        elif message_type == b"R":
            text = f"level = {octave_value(json.loads(body))};".encode()
            padding = bytes(NUMBER.size * (floats - 1))
            _write(NUMBER.pack(ord("R")) + NUMBER.pack(len(text)) + padding + text)
        else:
            _write(NUMBER.pack(ord("Q")) + bytes(NUMBER.size * floats))
            _read(ANSWER.size)  # Octave has flushed its output
            connection.quit()
        _relay_answer(connection, joints)


def _mapped(connection: Connection, header: "dict[str, Any]") -> mmap.mmap | None:
    """Return the memory of the images; None for a program that gets none."""
    description = header.get("images")
    if description is None:
        connection.close_others()
        return None
    descriptor = description["descriptor"]
    connection.close_others(descriptor)
    memory = mmap.mmap(descriptor, description["bytes"], prot=mmap.PROT_READ)
    os.close(descriptor)
    return memory


def _relay_image(message_type: bytes, body: bytes, images: mmap.mmap) -> None:
    """Relay a request with its image."""
    offset, *shape = IMAGE.unpack_from(body)
    corners = body[IMAGE.size :].ljust(CORNERS * NUMBER.size, b"\0")
    _write(NUMBER.pack(ord(message_type)) + struct.pack("<3d", *shape) + corners)
    _write_pixels(images, offset, *shape)


def _relay_observation(body: bytes, cameras: int, images: mmap.mmap, seen: bytes) -> bytes:
    """Relay an observation with its images, unless they are `seen`; return where they are."""
    numbers = len(body) - cameras * IMAGE.size
    shown = body[numbers:]
    _write(NUMBER.pack(ord("O")) + body[:numbers] + NUMBER.pack(shown != seen))
    if shown != seen:
        for image in IMAGE.iter_unpack(shown):
            _write_pixels(images, *image)
    return shown


def _write_pixels(images: mmap.mmap, offset: int, *shape: int) -> None:
    height, width, channels = shape
    with memoryview(images) as memory:
        _write(memory[offset : offset + height * width * channels])


def _write_program(filename: str, source: bytes) -> tuple[str, str]:
    """Write the program, or the files of an archive, where Octave reads them.

    Return the main file's own name, and its name here. It is given an additional first line, which
    makes it a script file that defines functions.
    """
    main_file = PROGRAM_FILE
    if source.startswith(ZIP_MAGIC):
        _extract(source)
        filename = main_file = next(main for main in MAINS if os.path.isfile(f"{FOLDER}/{main}"))
        with open(f"{FOLDER}/{main_file}", "rb") as file:
            source = file.read()
    with open(f"{FOLDER}/{main_file}", "wb") as file:
        file.write(b"1;\n" + source)
    return filename, main_file


def _extract(archive: bytes) -> None:
    import io  # noqa: PLC0415
    import zipfile  # noqa: PLC0415  (8 ms that a program of one file does not need)

    with zipfile.ZipFile(io.BytesIO(archive)) as members:
        members.extractall(FOLDER)


def octave_setup(header: "dict[str, Any]", names: tuple[str, str], floats: int) -> str:
    """Return what runner.m needs to know, as text in its language."""
    layout = header["layout"]
    booleans = set(layout.get("booleans", ()))
    fields, at = [], 1
    for name, count in layout.get("observation", ()):
        taken = f"v({at}:{at + count - 1})" if count else f"v({at})"
        fields.append(f"'{name}', {taken}{' != 0' if name in booleans else ''}")
        at += count or 1
    cameras = [name for name, *_size in layout.get("images", ())]
    sizes = [size for _name, *size in layout.get("images", ())]
    return (
        f"filename = {octave_value(names[0])};\n"
        f"main_file = {octave_value(names[1])};\n"
        f"role = {octave_value(layout.get('role', 'controller'))};\n"
        f"floats = {floats};\n"
        f"limits = {octave_value(list(command_limits(layout)))};\n"
        f"config = {octave_value(header['config'])};\n"
        f"observe = @(v) struct({', '.join(fields)});\n"
        f"cameras = {octave_value(cameras) if cameras else '{}'};\n"
        f"sizes = [{'; '.join(octave_value(size) for size in sizes)}];\n"
    )


def octave_value(value: object) -> str:
    """Return a JSON value as text in Octave's language; numbers stay the same to the last bit.

    Lists of numbers become rows, other lists cells. An object becomes a structure of those keys
    that are valid names.
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
        items = ", ".join(octave_value(item) for item in value)
        return f"[{items}]" if plain else f"{{{items}}}"
    if isinstance(value, dict):
        # In braces: a cell as a value of struct() would make an array of structures.
        named = [(key, octave_value(item)) for key, item in value.items() if NAME.fullmatch(key)]
        return "struct(" + ", ".join(f"'{key}', {{{item}}}" for key, item in named) + ")"
    raise TypeError(f"JSON has no {type(value).__name__}")


def _send_text(text: str) -> None:
    data = text.encode()
    _write(NUMBER.pack(len(data)) + data)


def _relay_answer(connection: Connection, joints: int) -> None:
    """Relay one answer of Octave."""
    letter, *numbers = ANSWER.unpack(_read(ANSWER.size))
    if letter == READY:
        connection.send(b"k")
    elif letter == FAILED:
        verdict, sentence, text = (int(number) for number in numbers[:3])
        reason = _read(sentence).decode("utf-8", "replace")
        connection.give_up(bytes([verdict]), reason, _read(text).decode("utf-8", "replace"))
    elif letter in (TRACK, DETECTIONS):
        count = min(int(numbers[0]), MAX_ANSWER_FLOATS)
        more = struct.unpack(f"<{count}d", _read(NUMBER.size * count))
        body = struct.pack(f"<{count}d", *more) if letter == TRACK else _packed_detections(more)
        connection.send(bytes([int(letter)]), body)
    else:
        connection.send(b"c", struct.pack("<4d", *numbers) + _read(NUMBER.size * joints))


def _packed_detections(numbers: tuple[float, ...]) -> bytes:
    """Return detections in the format of a message."""
    parts, at = [], 0
    while at < len(numbers):
        label = at + CORNERS + 2
        size = int(numbers[label - 1])
        text = bytes(int(code) & 255 for code in numbers[label : label + size])
        parts.append(DETECTION.pack(*numbers[at : label - 1], size) + text)
        at = label + size
    return COUNT.pack(len(parts)) + b"".join(parts)


def _write(data: bytes | memoryview) -> None:
    while data:
        data = data[os.write(1, data) :]


def _read(size: int) -> bytes:
    """Return what Octave wrote; exit if Octave is gone."""
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
