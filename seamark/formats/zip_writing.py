"""Zip archives without dates, written to a file that can neither be read nor positioned."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from typing import BinaryIO

COMPRESSION_LEVEL = 4  # of text: takes less time than writing it


def new_archive(file: BinaryIO, *, compressed: bool) -> zipfile.ZipFile:
    """Begin an archive."""
    method = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    return zipfile.ZipFile(file, "w", method, compresslevel=COMPRESSION_LEVEL)


def add(archive: zipfile.ZipFile, name: str, pieces: Iterable[bytes]) -> None:
    """Write a file of any length, piece by piece; by its name alone it is dated 1980."""
    with archive.open(name, "w", force_zip64=True) as file:
        for piece in pieces:
            file.write(piece)
