"""`seamark identify`: drag and added mass of a vehicle from a log of its motion."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.identification.identified import Identified, Parameter
    from seamark.identification.series import Series
    from seamark.mission_logs.mapping import LogMapping
    from seamark.sim.vehicles import Vehicle

_PICTURES = (".png", ".pdf", ".svg")


@click.command()
@click.argument("log", type=click.Path(exists=True, path_type=Path))
@click.option(
    "--vehicle",
    "source",
    metavar="FILE|NAME",
    required=True,
    help="The vehicle to start from: a file in TOML, or the name of one of Seamark's.",
)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.toml",
    help="File for the vehicle with the fitted numbers; it must not exist.",
)
@click.option(
    "--mapping",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="FILE",
    help="A file in TOML or JSON that says what the columns or topics are, and their units.",
)
@click.option(
    "--plot",
    "picture",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.png",
    help="Draw what was measured and what the fitted vehicle predicts (also .pdf, .svg).",
)
@json_option
def identify(
    *,
    log: Path,
    source: str,
    out: Path | None,
    mapping: Path | None,
    picture: Path | None,
    as_json: bool,
) -> None:
    """Fit drag and added mass of a vehicle to a log, and write the vehicle's file.

    LOG is a CSV file (telemetry.csv of a run is one), an MCAP file or a ROS bag. Columns, in SI
    units and body axes x forward, y starboard, z down, unless --mapping says otherwise:

    \b
      t                      time [s]
      u v w                  velocity over ground [m/s]: DVL
      p q r                  angular rates [rad/s]: gyro
      roll pitch yaw         attitude [rad], or a quaternion qx qy qz qw
      command_0 ...          command of each thruster, -1 to 1, until the next row; or
      thrust_0 ...           thrust of each thruster [N]; or
      force_x force_y force_z moment_x moment_y moment_z    the whole wrench [N, N m]
      current_x current_y    optional: velocity of the water, north and east [m/s]

    At least one velocity and what drove the vehicle are needed. A cell of a measured velocity or
    angle may be empty where there was no reading. docs/identification.md says how to drive a tank
    day, what is fitted and what the intervals mean.

    \b
    Examples:
      seamark identify tank.csv --vehicle my_rov.toml --out fitted.toml --plot fit.png
      seamark identify result/telemetry.csv --vehicle bluerov2-heavy-v2 --out fitted.toml
      seamark run currents-v3 --controller pi --set vehicle=fitted.toml
    """
    from seamark.cli.output_folder import draft_of
    from seamark.identification.identified import identify as identified_of
    from seamark.identification.series import read_series
    from seamark.identification.vehicle_file import FileNotEdited, fitted_file
    from seamark.mission_logs.result import LogRefused

    _refuse_outputs(out, picture)
    _refuse_without_rosbags(log)
    text, vehicle = _vehicle(source)
    try:
        series = read_series(log, _mapping(mapping), vehicle)
        found = identified_of(series, vehicle)
        file = fitted_file(text, vehicle, found, source=_told_source(log, series))
    except (LogRefused, FileNotEdited) as reason:
        raise UsageRefused(f"{log}: {reason}") from None
    if out is not None:
        with draft_of(out) as draft:
            draft.write(file.encode())
    if picture is not None:
        _draw(series, found, picture)
    if as_json:
        print_json(_document(series, found, out))
    else:
        for line in _lines(series, found, vehicle, out):
            click.echo(line)


def _refuse_outputs(out: Path | None, picture: Path | None) -> None:
    from seamark.cli.extras import install_line, missing

    if out is not None and out.suffix != ".toml":
        raise UsageRefused(f"{out}: a vehicle's file has a name with .toml.")
    if out is not None and out.exists():
        raise UsageRefused(f"{out} exists: choose another file, or remove it.")
    if picture is not None and picture.suffix.lower() not in _PICTURES:
        raise UsageRefused(f"{picture}: give the picture a name with {', '.join(_PICTURES)}.")
    if picture is not None and missing(("matplotlib",)):
        raise UsageRefused(f"Pictures need matplotlib: {install_line('plot')}.")


def _refuse_without_rosbags(log: Path) -> None:
    from seamark.cli.extras import install_line, missing
    from seamark.mission_logs.scope import ROS_SUFFIXES

    if (log.is_dir() or log.suffix in ROS_SUFFIXES) and missing(("rosbags",)):
        raise UsageRefused(f"MCAP files and ROS bags need rosbags: {install_line('ros')}.")


def _vehicle(source: str) -> tuple[str, Vehicle]:
    """Return the text of a vehicle's file and the vehicle; one of Seamark's is extended."""
    from seamark.identification.vehicle_file import extending
    from seamark.sim.registry import VEHICLES
    from seamark.sim.vehicles import load, own
    from seamark.sim.vehicles.reading import VehicleInvalid, read_vehicle

    if source in VEHICLES:
        return extending(load(source)), load(source)
    if not Path(source).is_file():
        raise UsageRefused(
            f"{source} is neither a file nor one of our vehicles: {', '.join(VEHICLES)}."
        )
    try:
        content = own.content_of(Path(source))
        vehicle = read_vehicle(content, base=load)
    except VehicleInvalid as invalid:
        raise UsageRefused(f"{source}: {invalid}") from None
    return content.decode("utf-8-sig"), vehicle


def _mapping(file: Path | None) -> LogMapping:
    from seamark.mission_logs.mapping import LogMapping

    try:
        return LogMapping.parse("" if file is None else file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UsageRefused(f"{file} cannot be read: {error}.") from None


def _told_source(log: Path, series: Series) -> str:
    """Return what a vehicle's file says about where its numbers are from."""
    from seamark.sandbox.printable_text import printable_text

    name = printable_text(log.name)[:80]
    digest = ""
    if log.is_file():
        with log.open("rb") as file:
            digest = f" (SHA-256 {hashlib.file_digest(file, 'sha256').hexdigest()[:16]})"
    return (
        f"seamark identify of {name}{digest}, {len(series.windows)} windows, "
        "as true as the thrust and the rigid mass of this file"
    )


def _draw(series: Series, found: Identified, picture: Path) -> None:
    from seamark.cli.output_folder import draft_of
    from seamark.identification.charts import charts
    from seamark.plots.picture import save

    drawn = charts(series, found)
    with draft_of(picture) as file:
        save(drawn, file, kind=picture.suffix[1:].lower(), title="Measured and predicted")


def _document(series: Series, found: Identified, out: Path | None) -> dict[str, Any]:
    return {
        "parameters": [
            {
                "name": one.name,
                "unit": one.unit,
                "before": one.before,
                "value": one.value,
                "interval": one.interval,
                "fitted": one.margin is not None,
            }
            for one in found.parameters
        ],
        "predictions": [
            {
                "channel": one.channel,
                "readings": one.readings,
                "rms_before": one.before,
                "rms_after": one.after,
                "held_out_before": one.held_out[0] if one.held_out else None,
                "held_out_after": one.held_out[1] if one.held_out else None,
                "correlation": None if math.isnan(one.correlation) else one.correlation,
            }
            for one in found.predictions
        ],
        "white": found.white,
        "windows": found.windows,
        "driven_by": series.driven_by,
        "notes": list(series.notes),
        "out": str(out) if out else None,
    }


def _lines(series: Series, found: Identified, vehicle: Vehicle, out: Path | None) -> Iterator[str]:
    """Yield what is printed."""
    from seamark.identification.series import WINDOW_S

    yield (
        f"{vehicle.name}, driven by {series.driven_by}, {len(series.t)} rows in {found.windows} "
        f"windows of at most {WINDOW_S:g} s"
    )
    yield from series.notes
    yield ""
    yield f"{'':24} {'before':>9} {'fitted':>9}   95 % interval"
    yield from (_parameter_line(one) for one in found.fitted)
    left = [one.name for one in found.parameters if one not in found.fitted]
    if left:
        yield f"Left as they are, since the log does not tell them: {'; '.join(left)}."
    yield ""
    heads = f"{'before':>9} {'fitted':>9}   {'held out: before':>16} {'fitted':>9}"
    yield f"{'rms error of':12} {heads}"
    for one in found.predictions:
        judged = "" if one.held_out is None else "{:16.2g} {:9.2g}".format(*one.held_out)
        unit = "m/s" if one.channel in "uvw" else "rad/s" if one.channel in "pqr" else "rad"
        yield f"{one.channel + ' ' + unit:12} {one.before:9.2g} {one.after:9.2g}   {judged}"
    yield from _remarks(found)
    if out is not None:
        yield f"{out} written. Next: seamark vehicle check {out}"


def _parameter_line(one: Parameter) -> str:
    start = f"{one.name:24} {one.before:9.4g} {one.value:9.4g}"
    if one.below is not None:
        low, high = one.below
        return f"{start}   held at 0: without a bound {low:.3g} to {high:.3g} {one.unit}"
    low, high = one.interval or (math.nan, math.nan)
    return f"{start}   {low:.4g} to {high:.4g} {one.unit}"


def _remarks(found: Identified) -> Iterator[str]:
    """Yield what a reader has to know about the numbers."""
    if any(one.held_out for one in found.predictions):
        yield "Held out: the last 30 % of the windows, predicted by a fit of the others."
    if found.not_judged:
        yield f"The part that is not held out does not excite {', '.join(found.not_judged)}."
    if not found.white:
        yield (
            "The residuals are not white: successive errors are alike, so the equations leave "
            "something out. The intervals allow for it as far as windows are independent."
        )
    yield (
        "A factor in all thrusts cannot be told from one in masses and drag: these numbers are as "
        "true as the thrust and the rigid mass of the file."
    )
