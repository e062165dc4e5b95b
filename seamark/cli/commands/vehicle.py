"""`seamark vehicle`: check, draw and import the files of vehicles."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.sim.vehicles import Vehicle

_LEFT_OUT_MAX = 30  # more are not listed


@click.group()
def vehicle() -> None:
    """Check, draw or import the file of a vehicle; docs/vehicles.md describes it.

    \b
    Examples:
      seamark vehicle check my_rov.toml --draw my_rov.svg
      seamark vehicle check bluerov2-heavy-v2
      seamark vehicle import my_rov.urdf -o my_rov.toml
      seamark run currents-v2 --set vehicle=my_rov.toml
    """


@vehicle.command()
@click.argument("source", metavar="FILE")
@click.option(
    "--draw",
    "picture",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.svg",
    help="Draw the vehicle from three sides.",
)
@json_option
def check(*, source: str, picture: Path | None, as_json: bool) -> None:
    """Say what is wrong with a vehicle, and what it can do.

    FILE is a file in TOML, or the name of a vehicle of Seamark. Exit code 1: the vehicle cannot
    run. Warnings do not prevent a run.
    """
    from seamark.cli.vehicle_report import figures, lines
    from seamark.sim.vehicles.plausibility import findings
    from seamark.sim.vehicles.reading import VehicleInvalid

    _refuse_other_pictures(picture)
    try:
        vehicle = _vehicle_of(source)
    except VehicleInvalid as invalid:
        _tell_invalid(source, invalid.errors, as_json=as_json)
        exit_with(1)
    told = findings(vehicle)
    errors = [one.text for one in told if one.grade == "error"]
    warnings = [one.text for one in told if one.grade == "warning"]
    if picture is not None:
        _draw(vehicle, picture)
    if as_json:
        document = {"name": vehicle.name, "errors": errors, "warnings": warnings}
        print_json(document | ({} if errors else {"figures": figures(vehicle)}))
    else:
        for line in lines(vehicle, errors, warnings):
            click.echo(line)
    exit_with(1 if errors else 0)


@vehicle.command(name="import")
@click.argument("urdf", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o",
    "out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.toml",
    required=True,
    help="File for the vehicle; it must not exist.",
)
@click.option(
    "--z-down",
    is_flag=True,
    help="The URDF's frames have y to starboard and z down, as in the URDF that Seamark writes. "
    "Without it y is to port and z up, as ROS has it.",
)
@json_option
def import_(*, urdf: Path, out: Path, z_down: bool, as_json: bool) -> None:
    """Write a vehicle's file from a URDF, and list what it leaves out.

    Masses, inertias, boxes, cylinders, spheres and colours of the base link and of the links fixed
    to it are read. Meshes and other joints are left out. URDF knows neither water nor thrusters:
    their numbers are placeholders, tagged E, for you to replace.
    """
    from seamark.cli.output_folder import draft_of
    from seamark.sim.vehicles import load
    from seamark.sim.vehicles.reading import VehicleInvalid, read_vehicle
    from seamark.sim.vehicles.urdf_import import UrdfRefused, import_urdf
    from seamark.sim.vehicles.xml_reading import BYTES_MAX

    if out.exists():
        raise UsageRefused(f"{out} exists: choose another file, or remove it.")
    with urdf.open("rb") as file:
        content = file.read(BYTES_MAX + 1)
    try:
        imported = import_urdf(content, z_down=z_down)
        read_vehicle(imported.text.encode(), base=load)
    except (UrdfRefused, VehicleInvalid) as reason:
        raise UsageRefused(f"{urdf}: {reason}") from None
    with draft_of(out) as draft:
        draft.write(imported.text.encode())
    if as_json:
        print_json({"out": str(out), "left_out": list(imported.left_out)})
        return
    click.echo(f"{out} written. Replace what is tagged E in it: URDF has no water, no thrusters.")
    if imported.left_out:
        click.echo("Left out:")
    for sentence in imported.left_out[:_LEFT_OUT_MAX]:
        click.echo(_printable(f"  {sentence}"))
    if len(imported.left_out) > _LEFT_OUT_MAX:
        click.echo(f"  {len(imported.left_out) - _LEFT_OUT_MAX} more.")
    click.echo(f"Next: seamark vehicle check {out} --draw {out.with_suffix('.svg')}")


def _vehicle_of(source: str) -> Vehicle:
    """Return the vehicle of a file or of a name; raises UsageRefused, VehicleInvalid."""
    from seamark.sim.registry import VEHICLES
    from seamark.sim.vehicles import load, own
    from seamark.sim.vehicles.reading import read_vehicle

    if source in VEHICLES:
        return load(source)
    if not Path(source).is_file():
        raise UsageRefused(
            f"{source} is neither a file nor one of our vehicles: {', '.join(VEHICLES)}."
        )
    return read_vehicle(own.content_of(Path(source)), base=load)


def _refuse_other_pictures(picture: Path | None) -> None:
    if picture is not None and picture.suffix.lower() != ".svg":
        raise UsageRefused(f"{picture}: drawings are SVG; give the file a name with .svg.")


def _draw(vehicle: Vehicle, picture: Path) -> None:
    from seamark.cli.output_folder import draft_of
    from seamark.sim.vehicles.drawing import drawing

    with draft_of(picture) as file:
        file.write(drawing(vehicle).encode())


def _tell_invalid(source: str, errors: tuple[str, ...], *, as_json: bool) -> None:
    if as_json:
        print_json({"name": None, "errors": list(errors), "warnings": []})
        return
    click.echo(_printable(f"{source} cannot be read as a vehicle."))
    for text in errors:
        click.echo(_printable(f"error    {text}"))


def _printable(text: str) -> str:
    from seamark.sandbox.printable_text import printable_text

    return printable_text(text)
