"""The archive of a run: all that `seamark rerun` needs to compute it again, in one zip file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any, BinaryIO

from seamark.formats import csv_file, zip_writing
from seamark.formats.recording import Recording

FOLDER = "seamark-run"
README, MANIFEST, CONFIG, METRICS = "README.md", "manifest.json", "config.json", "metrics.json"
TELEMETRY, PROGRAM, PARTS = "telemetry.csv", "program", "parts"
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
| parts/ | the same of programs in further roles, a folder for each role |
{published}
{again}
"""
_PUBLISHED = """\
| CITATION.cff, citation.bib | how the run is cited |
| .zenodo.json | the metadata of a deposit at Zenodo |
| LICENSE | the name of the licence of the program, if there is one, and the address of its text |
"""
_AGAIN = "`seamark rerun FILE.zip` computes the run again and compares it with this archive."
# What stands in a manifest in place of a controller: the log of a mission, or what was connected.
LOG = "log"
CONNECTED = ("rosbridge", "ardusub")


def why_not_again(manifest: Mapping[str, Any]) -> str:
    """Return why a run cannot be computed again from its archive; empty if it can."""
    controller = manifest.get("controller")
    if manifest.get("program_sha256") is not None:
        return ""
    if controller == LOG:
        return (
            "This is the log of a real mission: it was measured, not simulated, and cannot be "
            "computed again. `seamark replay` measures the file of the log."
        )
    if controller in CONNECTED:
        return (
            f"The program of this run was connected by {controller} and is not in the archive, so "
            "the run cannot be computed again from it. Start the program with `seamark bridge "
            f"{controller} {manifest['benchmark']} --config config.json --seed {manifest['seed']} "
            f"--trials {manifest['trials']}` instead."
        )
    return ""


def write(recording: Recording, file: BinaryIO) -> None:
    """Write the archive; a run that has not ended has neither manifest nor metrics."""
    with zip_writing.new_archive(file, compressed=True) as archive:
        for name, content in _documents(recording):
            zip_writing.add(archive, f"{FOLDER}/{name}", [content])
        zip_writing.add(archive, f"{FOLDER}/{TELEMETRY}", csv_file.pieces(recording))


def _documents(recording: Recording) -> Iterator[tuple[str, bytes]]:
    yield README, _readme(recording).encode()
    yield CONFIG, _json(recording.config)
    if recording.manifest is not None:
        yield MANIFEST, _json(recording.manifest)
    if recording.metrics is not None:
        yield METRICS, _json(recording.metrics)
    if recording.program is not None:
        name = PurePosixPath(recording.program.name).name or "program"
        yield f"{PROGRAM}/{name}", recording.program.content
    for role, part in recording.parts.items():
        yield f"{PARTS}/{role}/{PurePosixPath(part.name).name or 'program'}", part.content
    for name, content in recording.extra_files.items():
        yield name, content.encode()


def _readme(recording: Recording) -> str:
    why_not = "" if recording.manifest is None else why_not_again(recording.manifest)
    return _README.format(
        title=recording.title,
        benchmark=recording.benchmark,
        published=_PUBLISHED if recording.extra_files else "",
        again=why_not or _AGAIN,
    )


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=2, sort_keys=True, allow_nan=False) + "\n").encode()
