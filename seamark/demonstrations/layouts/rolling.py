"""Parquet files of a bounded size: the next one begins when one has become large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

FILES_A_CHUNK = 1000


class RollingTables:
    """Writes tables of one schema to `chunk-000/file-000.parquet` and so on; a context manager.

    The same tables give the same bytes.
    """

    def __init__(self, folder: Path, *, limit_bytes: int) -> None:
        self._folder, self._limit = folder, limit_bytes
        self._number = 0
        self._file: Any = None
        self._writer: Any = None

    def __enter__(self) -> RollingTables:
        """Begin."""
        return self

    def __exit__(self, *_: object) -> None:
        """Complete the last file."""
        self._close()

    @property
    def place(self) -> tuple[int, int]:
        """The numbers of chunk and file to which the next table goes."""
        return divmod(self._number, FILES_A_CHUNK)

    def write(self, table: Any) -> None:
        """Write a table as a row group."""
        import pyarrow.parquet as pq

        if self._writer is None:
            path = self._folder / path_of(*self.place)
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("wb")
            self._writer = pq.ParquetWriter(self._file, table.schema, compression="snappy")
        self._writer.write_table(table)
        if self._file.tell() >= self._limit:
            self._close()
            self._number += 1

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.close()
            self._file.close()
            self._writer = None


def path_of(chunk: int, file: int, suffix: str = "parquet") -> str:
    """Return where a file is."""
    return f"chunk-{chunk:03d}/file-{file:03d}.{suffix}"
