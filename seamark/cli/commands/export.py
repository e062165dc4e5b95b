"""`seamark export`: a result as a file that other programs read."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option, part_options, parts_in, server_options
from seamark.failures import UsageRefused
from seamark.formats.registry import FORMATS, Format

if TYPE_CHECKING:
    from seamark.formats.recording import Program


_HELP = f"""Write a run of a server, or a result of `seamark run --out`, as a file.

\b
{chr(10).join(f"{name:<8} {kind.label}" for name, kind in FORMATS.items())}

\b
Examples:
  seamark export 42 --format mcap -o run.mcap
  seamark export result --format parquet
"""


@click.command(help=_HELP)
@click.argument("result", metavar="RUN|FOLDER")
@click.option(
    "--format", "name", type=click.Choice(list(FORMATS)), required=True, help="What to write."
)
@click.option(
    "-o",
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="The file to write.  [default: named after the result]",
)
@click.option(
    "--program",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="The program of a result in a folder, for its archive.",
)
@part_options
@server_options
@json_option
def export(
    *,
    result: str,
    name: str,
    out: Path | None,
    program: Path | None,
    server: str,
    token: str | None,
    as_json: bool,
    **parts: Path | None,
) -> None:
    """Write a run as a file."""
    from seamark.cli.output_folder import draft_of
    from seamark.cli.results import is_run

    kind = FORMATS[name]
    on_server = is_run(result)
    stem = f"seamark-run-{result}" if on_server else Path(result).resolve().name
    target = out or Path(f"{stem}-{kind.file}")
    with draft_of(target) as file:
        if on_server:
            _download(int(result), kind, file, server=server, token=token)
        else:
            _write(Path(result), kind, file, program, parts_in(parts))
        size = file.tell()
    if as_json:
        print_json({"out": str(target), "format": name, "bytes": size})
    else:
        click.echo(f"{size / 2**20:.1f} MiB: {target}")


def _download(run_id: int, kind: Format, file: BinaryIO, *, server: str, token: str | None) -> None:
    """Have the server write it."""
    from seamark.cli.server_answers import refusals_shown
    from seamark.client import Client

    with refusals_shown(), Client(server, token) as client:
        client.run(run_id).download(kind.name, file)


def _write(
    folder: Path, kind: Format, file: BinaryIO, program: Path | None, parts: Mapping[str, Path]
) -> None:
    """Write a result on this machine."""
    from seamark.cli.extras import has_simulator, install_line, missing, without_simulator

    if not has_simulator():
        raise without_simulator("The export of a result in a folder")
    from seamark.formats.folder import NoResult, recording_of
    from seamark.formats.recording import FormatRefused

    if not folder.is_dir():
        raise UsageRefused(f"{folder} is neither a folder nor the number of a run.")
    if missing(kind.packages):
        raise UsageRefused(
            f"The format {kind.name} needs further packages: {install_line('formats')}."
        )
    try:
        own = {role: _program(part) for role, part in parts.items()}
        recording = recording_of(folder, None if program is None else _program(program), own)
        kind.write(recording, file)
    except (NoResult, FormatRefused) as reason:
        raise UsageRefused(str(reason)) from None


def _program(path: Path) -> Program:
    from seamark.cli.solutions import file_of
    from seamark.formats.recording import Program

    file = file_of(path)
    return Program(file.name, file.read_bytes())
