"""NumPy's NPZ: the rows as one structured array, with the units beside it.

`numpy.load(file)["telemetry"]["distance"]` is a column. The rows stay together as they were
recorded, so that a file of any size is written in one pass; they are not compressed, since doubles
hardly become smaller and `numpy.load` reads plain ones ten times as fast.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from seamark.formats import zip_writing
from seamark.formats.recording import Recording


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the arrays `telemetry`, `columns`, `units`, `meanings` and `description`."""
    columns = recording.columns
    with zip_writing.new_archive(file, compressed=False) as archive:
        zip_writing.add(archive, "telemetry.npy", _rows(recording))
        for name, texts in (
            ("columns", [column.name for column in columns]),
            ("units", [column.unit for column in columns]),
            ("meanings", [column.meaning for column in columns]),
            ("description", recording.description()),
        ):
            zip_writing.add(archive, f"{name}.npy", [_array(np.array(texts))])


def _rows(recording: Recording) -> Iterator[bytes]:
    head = io.BytesIO()
    described = {"descr": recording.dtype.descr, "fortran_order": False}
    npy.write_array_header_1_0(head, described | {"shape": (recording.row_count,)})
    yield head.getvalue()
    for rows in recording.blocks():
        yield np.ascontiguousarray(rows, dtype="<f8").tobytes()


def _array(values: NDArray[Any]) -> bytes:
    encoded = io.BytesIO()
    npy.write_array(encoded, values, allow_pickle=False)
    return encoded.getvalue()
