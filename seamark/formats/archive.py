"""The archive of a run: all that `seamark rerun` needs to compute it again, in one zip file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import BinaryIO

from seamark.formats import csv_file, zip_writing
from seamark.formats.recording import Recording

FOLDER = "seamark-run"
README, MANIFEST, CONFIG, METRICS = "README.md", "manifest.json", "config.json", "metrics.json"
TELEMETRY, PROGRAM = "telemetry.csv", "program"
_README = """\
# {title}

{benchmark}, written by Seamark.

| file | holds |
|---|---|
| manifest.json | versions, configuration, seeds, digest of the telemetry |
| config.json | the configuration, for `seamark run --config` |
| metrics.json | score and metrics |
| telemetry.csv | all rows: comment lines with #, then the names of the columns |
| program/ | the uploaded program, if there was one and it may be passed on |

`seamark rerun FILE.zip` computes the run again and compares it with this archive.
"""


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the archive; a run that has not ended has neither manifest nor metrics."""
    with zip_writing.new_archive(file, compressed=True) as archive:
        for name, content in _documents(recording):
            zip_writing.add(archive, f"{FOLDER}/{name}", [content])
        zip_writing.add(archive, f"{FOLDER}/{TELEMETRY}", csv_file.pieces(recording))


def _documents(recording: Recording) -> Iterator[tuple[str, bytes]]:
    text = _README.format(title=recording.title, benchmark=recording.benchmark)
    yield README, text.encode()
    yield CONFIG, _json(recording.config)
    if recording.manifest is not None:
        yield MANIFEST, _json(recording.manifest)
    if recording.metrics is not None:
        yield METRICS, _json(recording.metrics)
    if recording.program is not None:
        name = PurePosixPath(recording.program.name).name or "program"
        yield f"{PROGRAM}/{name}", recording.program.content
    for name, content in recording.extra_files.items():
        yield name, content.encode()


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=2, sort_keys=True, allow_nan=False) + "\n").encode()
