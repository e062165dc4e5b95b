"""MATLAB's MAT-file, version 7: a variable for each column, for `load` in MATLAB and Octave.

SciPy writes variables, but also the date into the head of the file. A MAT-file is its head and then
one variable after the other, so they are written a few at a time below a head without a date.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any, BinaryIO

from seamark.formats.recording import FormatRefused, Recording
from seamark.formats.registry import FORMATS

# Some columns are held at a time; for the others all rows are read again.
VALUES_AT_A_TIME = 8_000_000  # 64 MB
HEAD_TEXT = b"MATLAB 5.0 MAT-file, written by Seamark"
_HEAD_BYTES, _TEXT_BYTES = 128, 116
_VERSION = b"\x00\x01IM"  # 0x0100, and the byte order: little-endian


def write(recording: Recording, file: BinaryIO) -> None:
    """Write a column vector per column, then the structures `units`, `meanings`, `description`.

    Raises
    ------
    FormatRefused
        There are more rows than the registry allows.
    """
    if reason := FORMATS["mat"].refusal(recording.row_count):
        raise FormatRefused(reason)
    columns = recording.columns
    file.write(HEAD_TEXT.ljust(_TEXT_BYTES) + bytes(8) + _VERSION)
    at_a_time = max(1, VALUES_AT_A_TIME // max(1, recording.row_count))
    for first in range(0, len(columns), at_a_time):
        some = columns[first : first + at_a_time]
        values = recording.columns_at(first, len(some))
        for column, vector in zip(some, values, strict=True):
            file.write(_variables({column.name: vector}))
    file.write(
        _variables(
            {
                "units": {column.name: column.unit for column in columns},
                "meanings": {column.name: column.meaning for column in columns},
                "description": recording.description(),
            }
        )
    )


def _variables(values: Mapping[str, Any]) -> bytes:
    from scipy.io import savemat

    encoded = io.BytesIO()
    savemat(encoded, dict(values), do_compression=True, oned_as="column", long_field_names=True)
    return encoded.getvalue()[_HEAD_BYTES:]
