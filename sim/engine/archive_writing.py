"""Writes archives of data sets in pieces: the same files give the same bytes."""

import csv
import io
import json
import zipfile
from collections.abc import Iterable, Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

FOLDER = "seamark-dataset"
Member = tuple[str, bytes | Iterable[bytes]]  # name and contents, whole or in pieces
Line = list[object]
_PNG_LEVEL = 1  # fast; noise does not compress anyway


def png(image: NDArray[np.uint8]) -> bytes:
    """Return an image as a PNG file."""
    encoded, data = cv2.imencode(".png", image, [cv2.IMWRITE_PNG_COMPRESSION, _PNG_LEVEL])
    if not encoded:
        raise RuntimeError("OpenCV could not encode an image")
    return bytes(np.asarray(data).tobytes())


def json_file(value: object) -> bytes:
    """Return a JSON file for people."""
    return (json.dumps(value, indent=2, allow_nan=False) + "\n").encode()


def csv_lines(lines: Iterable[Iterable[object]]) -> bytes:
    """Return lines of a CSV file."""
    table = io.StringIO()
    csv.writer(table, lineterminator="\n").writerows(lines)
    return table.getvalue().encode()


def zipped(members: Iterable[Member]) -> Iterator[bytes]:
    """Yield a ZIP archive, at most one piece for each piece of the files in it, and its end."""
    sink = _Sink()
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_STORED) as file:
        for name, data in members:
            entry = zipfile.ZipInfo(f"{FOLDER}/{name}")  # its date is 1980: the same bytes always
            entry.external_attr = 0o644 << 16
            if isinstance(data, bytes):
                file.writestr(entry, data)
                yield sink.take()
                continue
            with file.open(entry, "w", force_zip64=True) as stream:
                for piece in data:
                    stream.write(piece)
                    yield sink.take()
    yield sink.take()


class _Sink(io.RawIOBase):
    """A file that keeps what is written until it is taken, for streaming an archive."""

    def __init__(self) -> None:
        self.pending = bytearray()

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:  # anything with a buffer
        self.pending += data
        return len(data)

    def take(self) -> bytes:
        piece = bytes(self.pending)
        self.pending.clear()
        return piece
