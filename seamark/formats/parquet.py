"""Apache Parquet: a column of float64 for each column of the telemetry, with its unit as metadata.

Values are PLAIN and compressed with Snappy, which every reader knows. Zstandard would save a
fifteenth, BYTE_STREAM_SPLIT another tenth.
"""

from __future__ import annotations

import json
from typing import Any, BinaryIO

import numpy as np

from seamark.formats.recording import Recording

_PANDAS = "PANDAS_ATTRS"  # what pandas.read_parquet makes the `attrs` of the data frame from
ROW_GROUP_ROWS = 50_000  # 20 MB: what readers load at a time


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the rows; a field has `unit` and `description`, the schema `seamark`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = _schema(recording)
    with pq.ParquetWriter(
        pa.PythonFile(file, mode="w"), schema, compression="snappy", use_dictionary=False
    ) as writer:
        for rows in recording.blocks(ROW_GROUP_ROWS):
            columns = [pa.array(np.ascontiguousarray(column)) for column in rows.T]
            writer.write_batch(pa.record_batch(columns, schema=schema))


def _schema(recording: Recording) -> Any:
    import pyarrow as pa

    fields = [
        pa.field(
            column.name,
            pa.float64(),
            nullable=False,
            metadata={"unit": column.unit, "description": column.meaning},
        )
        for column in recording.columns
    ]
    units = {column.name: column.unit for column in recording.columns}
    told = {"seamark": recording.description(), _PANDAS: json.dumps({"units": units})}
    return pa.schema(fields, metadata=told)
