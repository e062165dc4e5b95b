"""`seamark vehicle`: check, draw and import the files of vehicles and arms."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.sim.vehicles import Vehicle
    from seamark.sim.vehicles.plausibility import Finding

_LEFT_OUT_MAX = 30  # more are not listed


@click.group()
def vehicle() -> None:
    """Check, draw or import the file of a vehicle or of an arm; docs/vehicles.md describes it.

    \b
    Examples:
      seamark vehicle check my_rov.toml --draw my_rov.svg
      seamark vehicle check bluerov2-heavy-v2
      seamark vehicle check my_arm.toml --draw my_arm.svg
      seamark vehicle import my_rov.urdf -o my_rov.toml
      seamark vehicle import my_arm.urdf -o my_arm.toml --arm
      seamark run currents-v3 --set vehicle=my_rov.toml
    """


@vehicle.command()
@click.argument("source", metavar="FILE")
@click.option(
    "--draw",
    "picture",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.svg",
    help="Draw the vehicle or the arm from three sides.",
)
@json_option
def check(*, source: str, picture: Path | None, as_json: bool) -> None:
    """Say what is wrong with a vehicle or an arm, and what it can do.

    FILE is a file in TOML, or the name of a vehicle or an arm of Seamark. Exit code 1: it cannot
    run. Warnings do not prevent a run.
    """
    from seamark.sim.vehicles.fields import FileInvalid

    _refuse_other_pictures(picture)
    try:
        checked = _checked_arm(source) if _is_arm(source) else _checked_vehicle(source)
    except FileInvalid as invalid:
        _tell_invalid(source, invalid.errors, as_json=as_json)
        exit_with(1)
    if picture is not None:
        _write(checked.drawn(), picture)
    if as_json:
        document = {"name": checked.name, "errors": checked.errors, "warnings": checked.warnings}
        print_json(document | ({} if checked.errors else {"figures": checked.figures()}))
    else:
        for line in checked.lines():
            click.echo(line)
    exit_with(1 if checked.errors else 0)


@vehicle.command(name="import")
@click.argument("urdf", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o",
    "out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.toml",
    required=True,
    help="File for the vehicle or the arm; it must not exist.",
)
@click.option("--arm", is_flag=True, help="Write an arm's file: its joints, and all links.")
@click.option(
    "--z-down",
    is_flag=True,
    help="The URDF's frames have y to starboard and z down, as in the URDF that Seamark writes. "
    "Without it y is to port and z up, as ROS has it.",
)
@json_option
def import_(*, urdf: Path, out: Path, arm: bool, z_down: bool, as_json: bool) -> None:
    """Write a vehicle's or an arm's file from a URDF, and list what it leaves out.

    Masses, inertias, boxes, cylinders, spheres and colours of the base link and of the links fixed
    to it are read; with --arm all links, and joints with limits, efforts, speeds and friction.
    Meshes are left out, and other joints of a vehicle. URDF knows neither water nor thrusters:
    their numbers are placeholders, tagged E, for you to replace.
    """
    from seamark.cli.output_folder import draft_of
    from seamark.sim.vehicles import load
    from seamark.sim.vehicles.fields import FileInvalid
    from seamark.sim.vehicles.linkage_reading import read_linkage
    from seamark.sim.vehicles.reading import read_vehicle
    from seamark.sim.vehicles.urdf_arm_import import import_arm
    from seamark.sim.vehicles.urdf_import import import_urdf
    from seamark.sim.vehicles.urdf_tree import UrdfRefused
    from seamark.sim.vehicles.xml_reading import BYTES_MAX

    if out.exists():
        raise UsageRefused(f"{out} exists: choose another file, or remove it.")
    with urdf.open("rb") as file:
        content = file.read(BYTES_MAX + 1)
    try:
        imported = (import_arm if arm else import_urdf)(content, z_down=z_down)
        if arm:
            read_linkage(imported.text.encode())
        else:
            read_vehicle(imported.text.encode(), base=load)
    except (UrdfRefused, FileInvalid) as reason:
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


class _Checked(NamedTuple):
    """What is said about a vehicle or an arm."""

    name: str
    errors: list[str]
    warnings: list[str]
    figures: Callable[[], dict[str, Any]]
    lines: Callable[[], Iterable[str]]
    drawn: Callable[[], str]


def _checked_vehicle(source: str) -> _Checked:
    from seamark.sim.vehicles.drawing import drawing
    from seamark.sim.vehicles.plausibility import findings
    from seamark.sim.vehicles.report import figures, lines

    vehicle = _vehicle_of(source)
    errors, warnings = _graded(findings(vehicle))
    return _Checked(
        name=vehicle.name,
        errors=errors,
        warnings=warnings,
        figures=lambda: figures(vehicle),
        lines=lambda: lines(vehicle, errors, warnings),
        drawn=lambda: drawing(vehicle),
    )


def _checked_arm(source: str) -> _Checked:
    from seamark.cli.arm_report import figures_of, lines
    from seamark.sim.registry import ARMS
    from seamark.sim.vehicles import own
    from seamark.sim.vehicles.arm_check import figures, findings
    from seamark.sim.vehicles.arm_drawing import arm_drawing
    from seamark.sim.vehicles.linkage_reading import read_linkage

    content = ARMS[source].read_bytes() if source in ARMS else own.content_of(Path(source))
    arm = read_linkage(content)
    found = figures(arm)
    errors, warnings = _graded(findings(arm, found))
    return _Checked(
        name=arm.name,
        errors=errors,
        warnings=warnings,
        figures=lambda: figures_of(found),
        lines=lambda: lines(arm, found, errors, warnings),
        drawn=lambda: arm_drawing(arm),
    )


def _graded(told: Iterable[Finding]) -> tuple[list[str], list[str]]:
    """Return the texts of errors and of warnings."""
    told = list(told)
    return (
        [one.text for one in told if one.grade == "error"],
        [one.text for one in told if one.grade == "warning"],
    )


def _is_arm(source: str) -> bool:
    """Return whether a name or a file is that of an arm: the file says so."""
    from seamark.sim.registry import ARMS, VEHICLES
    from seamark.sim.vehicles import own
    from seamark.sim.vehicles.toml_reading import TomlRefused, read_toml

    if source in ARMS or source in VEHICLES or not Path(source).is_file():
        return source in ARMS
    try:
        return read_toml(own.content_of(Path(source))).get("kind") == "arm"
    except TomlRefused:
        return False


def _vehicle_of(source: str) -> Vehicle:
    """Return the vehicle of a file or of a name; raises UsageRefused, VehicleInvalid."""
    from seamark.sim.registry import ARMS, VEHICLES
    from seamark.sim.vehicles import load, own
    from seamark.sim.vehicles.reading import read_vehicle

    if source in VEHICLES:
        return load(source)
    if not Path(source).is_file():
        raise UsageRefused(
            f"{source} is neither a file nor one of our vehicles and arms: "
            f"{', '.join((*VEHICLES, *ARMS))}."
        )
    return read_vehicle(own.content_of(Path(source)), base=load)


def _refuse_other_pictures(picture: Path | None) -> None:
    if picture is not None and picture.suffix.lower() != ".svg":
        raise UsageRefused(f"{picture}: drawings are SVG; give the file a name with .svg.")


def _write(text: str, picture: Path) -> None:
    from seamark.cli.output_folder import draft_of

    with draft_of(picture) as file:
        file.write(text.encode())


def _tell_invalid(source: str, errors: tuple[str, ...], *, as_json: bool) -> None:
    if as_json:
        print_json({"name": None, "errors": list(errors), "warnings": []})
        return
    click.echo(_printable(f"{source} cannot be read as a vehicle or an arm."))
    for text in errors:
        click.echo(_printable(f"error    {text}"))


def _printable(text: str) -> str:
    from seamark.sandbox.printable_text import printable_text

    return printable_text(text)
