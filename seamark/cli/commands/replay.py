"""`seamark replay`: the log of a real mission, measured by the metrics of a benchmark."""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option
from seamark.failures import PlatformFailed, UsageRefused
from seamark.sim.registry import DEFAULT_BENCHMARK

if TYPE_CHECKING:
    from seamark.cli.output_folder import OutputFolder
    from seamark.mission_logs.mapping import LogMapping
    from seamark.mission_logs.result import LogResult

MISSING_SHOWN = 6  # metrics that the log does not allow, named on the terminal


@click.command()
@click.argument("log", type=click.Path(exists=True, path_type=Path))
@click.option(
    "--mapping",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="A file in TOML or JSON that says what the columns or topics are.",
)
@click.option(
    "--benchmark",
    metavar="NAME",
    help=f"Whose metrics.  [default: that of the mapping, or {DEFAULT_BENCHMARK}]",
)
@click.option(
    "--set",
    "pairs",
    multiple=True,
    metavar="KEY=VALUE",
    help="A setting of the benchmark, such as vehicle=bluerov2-heavy; repeatable.",
)
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Folder for the data.")
@json_option
def replay(
    *,
    log: Path,
    mapping: Path | None,
    benchmark: str | None,
    pairs: tuple[str, ...],
    out: Path | None,
    as_json: bool,
) -> None:
    """Measure the log of a real mission as a run is measured.

    LOG is a CSV file, an MCAP file or a ROS bag (a .bag or .db3 file, or the folder of a ROS 2
    bag) with the vehicle's pose, the corners of the target in the image, or both. Columns with
    usual names and a single topic with odometry need no mapping: the command prints what it took
    for what. --out DIR gets manifest.json, metrics.json and telemetry.csv, which `seamark plot` and
    `compare` read.

    \b
    Examples:
      seamark replay mission.csv --set settle_s=0 --out mission
      seamark replay mission.bag --mapping mission.toml --benchmark currents-v3 --json
    """
    from seamark.cli.output_folder import OutputFolder
    from seamark.mission_logs.result import LogRefused

    output = OutputFolder(out)
    try:
        result = _measure(log, _mapping(mapping, benchmark or "", pairs), benchmark)
    except LogRefused as reason:
        raise UsageRefused(f"{log}: {reason}") from None
    _save(output, result)
    if as_json:
        print_json(_document(result, out))
    else:
        _print(result, out)


def _mapping(file: Path | None, benchmark: str, pairs: tuple[str, ...]) -> LogMapping:
    from seamark.cli.configuration import benchmark_of, read_settings, typed, with_files
    from seamark.mission_logs.mapping import LogMapping

    try:
        text = "" if file is None else file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise UsageRefused(f"{file} cannot be read: {error}.") from None
    mapping = LogMapping.parse(text)
    name = benchmark or mapping.benchmark or DEFAULT_BENCHMARK
    changes = typed(with_files(read_settings(None, pairs)), benchmark_of(name).schema())
    settings = {**mapping.settings, **changes}
    return mapping.model_copy(update={"settings": settings, "benchmark": name})


def _measure(log: Path, mapping: LogMapping, benchmark: str | None) -> LogResult:
    import numpy as np

    from seamark.cli.extras import install_line, missing
    from seamark.mission_logs.limited import LogReaderBroken, measure_limited
    from seamark.mission_logs.scope import ROS_SUFFIXES

    if (log.is_dir() or log.suffix in ROS_SUFFIXES) and missing(("rosbags",)):
        raise UsageRefused(f"MCAP files and ROS bags need rosbags: {install_line('ros')}.")
    name = benchmark or mapping.benchmark or DEFAULT_BENCHMARK
    try:
        with tempfile.TemporaryDirectory(prefix="seamark-replay-") as folder:
            result = measure_limited(log, mapping, benchmark=name, folder=Path(folder))
            return replace(result, rows=np.array(result.rows, dtype=np.float64))
    except LogReaderBroken as error:
        raise PlatformFailed(f"The log reader failed.\n{error}") from None


def _save(output: OutputFolder, result: LogResult) -> None:
    from seamark.sim.recording import telemetry
    from seamark.worker.ipc.outcomes import RunOutcome

    log = result.manifest["log"]
    output.comments = [
        f"{result.manifest['kind']}: {log['name']}, SHA-256 {log['sha256']}",
        telemetry.units(result.rows.shape[1]),
    ]
    output.add_rows(result.rows)
    outcome = RunOutcome(metrics=result.metrics, manifest=result.manifest, digest=result.digest)
    output.save(result.benchmark, outcome)


def _document(result: LogResult, out: Path | None) -> dict[str, Any]:
    return {
        "benchmark": result.benchmark,
        "kind": result.manifest["kind"],
        "score": result.metrics["score"],
        "metrics": result.metrics,
        "manifest": result.manifest,
        "digest": result.digest,
        "out": str(out) if out else None,
    }


def _print(result: LogResult, out: Path | None) -> None:
    from seamark.cli.run_summary import level_table
    from seamark.sandbox.printable_text import printable_text

    manifest = result.manifest
    steps, period_s = len(result.rows), manifest["period_s"]
    lines = [
        f"{result.benchmark}, {manifest['kind']}: {steps} control steps of {period_s:g} s",
        *(["Resampled as the mapping says."] if manifest["resampled"] else []),
        *_guess_lines(manifest["guessed"]),
        f"measured  {', '.join(manifest['measured'])}",
        f"derived   {', '.join(manifest['derived']) or 'nothing'}",
        *level_table(result.metrics),
        *_missing_lines(result.metrics["not_measured"]),
    ]
    if result.metrics["score"] is not None:
        lines.append(f"score   {result.metrics['score']:.4g}")
    lines.append(f"digest  {result.digest}")
    if out is not None:
        lines.append(f"data    {out}")
    click.echo(printable_text("\n".join(lines)))


def _guess_lines(guessed: dict[str, Any]) -> list[str]:
    """Return what was guessed, as the mapping that says the same."""
    if not guessed:
        return []
    lines = ["The log was read like this. If that is wrong, edit it and pass it as --mapping FILE:"]
    if frame := guessed.get("frame"):
        lines += [f"    frame = {_quoted(frame)}"]
    if topics := guessed.get("topics"):
        lines += ["    [topics]", *(f"    {role} = {_quoted(topics[role])}" for role in topics)]
    if columns := guessed.get("columns"):
        lines += ["    [columns]", *(f"    {name} = {_source(columns[name])}" for name in columns)]
    return lines


def _source(source: dict[str, str]) -> str:
    name, unit = _quoted(source["name"]), source["unit"]
    return f"{{ name = {name}, unit = {_quoted(unit)} }}" if unit else name


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # as in TOML


def _missing_lines(missing: dict[str, list[str]]) -> list[str]:
    if not missing:
        return []
    names = [name for name in missing if not name.startswith("whole_")]
    needed = sorted({column for columns in missing.values() for column in columns})
    more = " and more" if len(names) > MISSING_SHOWN else ""
    return [
        f"The log has no columns {', '.join(needed)}. Seamark needs them to compute "
        f"{', '.join(names[:MISSING_SHOWN])}{more}."
    ]
