"""`seamark rerun`: compute an archived run again, and say what differs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.cli.solutions import FindIsolation
    from seamark.formats.archive_reading import ArchivedRun, Manifest
    from seamark.formats.recording import Program
    from seamark.programs.preparation import PreparedProgram
    from seamark.sim.recording.telemetry import Rows
    from seamark.worker.ipc.outcomes import RunOutcome


@click.command()
@click.argument("archive", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@json_option
def rerun(*, archive: Path, as_json: bool) -> None:
    """Compute a run again from its archive.zip, and compare the result with the archive.

    A program in the archive runs in the sandbox, as everybody's. Exit code 0: every number is the
    same; 1: something differs, and what is printed.

    \b
    Examples:
      seamark export 42 --format archive -o archive.zip
      seamark rerun archive.zip
    """
    from seamark.cli.solutions import probing
    from seamark.formats.archive_reading import ArchiveRefused, opened

    try:
        with opened(archive) as archived:
            boxes = archived.program is not None or len(archived.parts) > 0
            with probing(needed=boxes) as isolation:
                report = _report(archived, isolation, quiet=as_json)
    except ArchiveRefused as reason:
        raise UsageRefused(_printable(str(reason))) from None
    if as_json:
        print_json(report)
    else:
        _show(report)
    exit_with(0 if report["same"] else 1)


def _report(archived: ArchivedRun, isolation: FindIsolation, *, quiet: bool) -> dict[str, Any]:
    from seamark.cli import rerun_comparison

    manifest = archived.manifest
    _add_vehicle(manifest)
    _add_files(manifest)
    program = _program(archived)
    content = None if program is None else program.content
    parts = _parts(archived)
    contents = {role: part.content for role, part in parts.items()}
    differences = rerun_comparison.of_inputs(archived, content, contents)
    if not quiet:
        solution = manifest.controller if program is None else program.name
        what = f"{manifest.benchmark}, {solution}, trials {manifest.trials}"
        click.echo(_printable(what))
    outcome, rows = _computed(archived, program, parts, isolation, quiet=quiet)
    differences += rerun_comparison.of_results(archived, outcome, rows)
    here = outcome.manifest or {}
    software = rerun_comparison.of_software(manifest, here)
    if differences:
        software += rerun_comparison.of_processor(manifest, here)
    return {
        "same": not differences,
        "digest": outcome.digest,
        "archived_digest": manifest.digest,
        "failure": outcome.failure,
        "sentence": outcome.sentence,
        "differences": [_printable(line) for line in differences],
        "software": [_printable(line) for line in software],
    }


def _add_vehicle(manifest: Manifest) -> None:
    """Make the user's own vehicle of a run known here; raises UsageRefused."""
    from seamark.sim.vehicles import own
    from seamark.sim.vehicles.reading import VehicleInvalid

    if manifest.vehicle_file is None:
        return
    try:
        name = own.add(manifest.vehicle_file.text.encode())
    except VehicleInvalid as reason:
        raise UsageRefused(f"The vehicle in the archive: {reason}") from None
    if name != manifest.configuration.get(own.SETTING):
        raise UsageRefused(
            "The vehicle in the archive is another one than that of its configuration: the "
            "archive was changed."
        )


def _add_files(manifest: Manifest) -> None:
    """Make the user's other files of a run known here; raises UsageRefused."""
    from seamark.sim.files.library import FileInvalid
    from seamark.sim.settings.own_files import LIBRARIES

    for library in LIBRARIES.values():
        file = getattr(manifest, library.entry)
        if file is None:
            continue
        try:
            name = library.add(file.text.encode())
        except FileInvalid as reason:
            raise UsageRefused(f"The {library.what} in the archive: {reason}") from None
        if name != manifest.configuration.get(library.setting):
            raise UsageRefused(
                f"The {library.what} in the archive is another one than that of its configuration: "
                "the archive was changed."
            )


def _program(archived: ArchivedRun) -> PreparedProgram | None:
    """Return the program in normal form; raises UsageRefused if there is none although needed."""
    from seamark.cli.configuration import benchmark_of

    manifest, program = archived.manifest, archived.program
    benchmark = benchmark_of(manifest.benchmark)
    if program is None:
        if manifest.program_sha256 is not None:
            raise UsageRefused(
                "The archive has no program: it was not published. Ask its owner for an archive "
                "with it."
            )
        known = {*benchmark.built_in, *benchmark.reference_built_in}
        if manifest.controller not in known:
            raise UsageRefused(f"There is no built-in solution {manifest.controller}.")
        return None
    return _prepared(program, benchmark.role, what="program")


def _parts(archived: ArchivedRun) -> dict[str, PreparedProgram]:
    """Return the further programs in normal form; raises UsageRefused if one is not there."""
    from seamark.programs import parts
    from seamark.sim import registry

    for role in archived.manifest.parts:
        if refusal := parts.refusal(registry.benchmark(archived.manifest.benchmark), role):
            raise UsageRefused(refusal)
        if role not in archived.parts:
            raise UsageRefused(
                f"The archive does not have the {role} of the run: it was not published. Ask its "
                "owner for an archive with it."
            )
    return {role: _prepared(part, role, what=role) for role, part in archived.parts.items()}


def _prepared(program: Program, role: str, *, what: str) -> PreparedProgram:
    from seamark.programs.archives import is_archive
    from seamark.programs.preparation import UploadRejected, prepare

    # An uploaded archive is stored as a plain zip file, whatever it was and is called.
    name = "program.zip" if is_archive(program.name) else program.name
    try:
        return prepare(program.content, name, role=role)
    except UploadRejected as reason:
        raise UsageRefused(f"The {what} in the archive: {reason}") from None


def _computed(
    archived: ArchivedRun,
    program: PreparedProgram | None,
    parts: Mapping[str, PreparedProgram],
    isolation: FindIsolation,
    *,
    quiet: bool,
) -> tuple[RunOutcome, Rows]:
    """Compute the run with the configuration, seeds and program of the archive."""
    import numpy as np

    from seamark.cli.output_folder import RowsInMemory
    from seamark.cli.simulator_loading import loading_shown
    from seamark.cli.solutions import sandbox_failures_explained
    from seamark.progress import Progress
    from seamark.sim.recording.telemetry import WIDTH
    from seamark.sim.settings.refusal import ConfigurationInvalid

    manifest, rows = archived.manifest, RowsInMemory()
    seeds = manifest.trial_seeds()
    try:
        with (
            sandbox_failures_explained(),
            Progress(manifest.benchmark, quiet=quiet) as bar,
            loading_shown(bar),
        ):
            level = isolation(manifest.benchmark)
            from seamark.worker.evaluation.local import Callbacks, evaluate_seeds

            outcome = evaluate_seeds(
                manifest.benchmark,
                archived.config,
                seeds=seeds,
                ranked=manifest.seed is None,
                controller=program or manifest.controller,
                parts=parts,
                callbacks=Callbacks(
                    rows=rows.add,
                    trial_restarted=rows.discard,
                    progress=lambda p: bar.show(p.fraction, f"{p.t_simulated:.0f} s simulated"),
                ),
                isolation=level,
            )
    except ConfigurationInvalid as error:
        raise UsageRefused(f"config.json: {error}") from None
    return outcome, np.concatenate(rows.parts) if rows.parts else np.empty((0, WIDTH))


def _show(report: dict[str, Any]) -> None:
    if report["failure"] is not None:
        click.echo(_printable(f"Failed ({report['failure']}): {report['sentence']}"), err=True)
    for line in (*report["differences"], *report["software"]):
        click.echo(line)
    click.echo(f"digest  {report['digest']}")
    click.echo("Every number is the same." if report["same"] else "The result differs.")


def _printable(text: str) -> str:
    from seamark.sandbox.printable_text import printable_text

    return printable_text(text)
