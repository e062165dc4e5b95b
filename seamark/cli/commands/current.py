"""`seamark current`: make a record of currents, as a run takes it, of a file or of constituents."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.current_data.series import Made, Series


@click.command()
@click.argument(
    "source", metavar="FILE", type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option(
    "-o",
    "out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="RECORD.csv",
    help="Write the record; the file must not exist.",
)
@click.option(
    "--draw",
    "drawing",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.svg",
    help="Draw speed over time and the profile.",
)
@click.option("--bottom", "bottom_m", type=float, metavar="M", help="Depth of the bottom.")
@click.option("--step", "step_s", type=float, metavar="S", help="Time between two instants.")
@click.option(
    "--from", "first_h", type=float, default=0.0, metavar="HOURS", help="Leave out the beginning."
)
@click.option("--hours", type=float, metavar="HOURS", help="Length of the record.")
@click.option("--title", default="", help="Title of the record.")
@click.option("--licence", default="", help="Licence and owner of the data, kept in the record.")
@click.option("--tides", is_flag=True, help="FILE has tidal constituents.")
@click.option(
    "--begin", metavar="DATE", help="With --tides: the first instant, as 2026-05-01T00:00."
)
@click.option(
    "--latitude", type=float, default=45.0, show_default=True, help="With --tides, in degrees."
)
@click.option(
    "--height",
    type=float,
    default=2.0,
    show_default=True,
    help="With --tides: above the bottom, in m.",
)
@json_option
def current(
    *,
    source: Path,
    out: Path | None,
    drawing: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Say what a file of currents has, and write the record that a run takes.

    FILE is CSV (columns time, east, north, up, and depth or height, with units as in east_cm_s) or
    NetCDF with CF's standard names, or as DOLfYN writes it. With --tides it has constituents.

    \b
    Examples:
      seamark current adcp.nc -o ria.csv --draw ria.svg --licence "CC BY 4.0, the owner"
      seamark current model.nc --bottom 18 --step 600 -o shelf.csv
      seamark current --tides m2.csv --begin 2026-05-01T00:00 --hours 25 -o tide.csv
      seamark run currents-v3 --controller pi --set current_record=ria.csv
    """
    from seamark.current_data.picture import picture
    from seamark.current_data.series import CurrentRefused
    from seamark.sim.physics.water_motion.record import RecordInvalid, write_record

    _refuse_names(out, drawing)
    try:
        series, made = _made(source, options)
    except (CurrentRefused, RecordInvalid) as reason:
        raise UsageRefused(f"{source}: {reason}") from None
    if out is not None:
        _write(write_record(made.record), out)
    if drawing is not None:
        _write(picture(made.record).encode(), drawing)
    document = _document(series, made)
    if as_json:
        print_json(document)
        return
    for line in _lines(series, made):
        click.echo(_printable(line))
    if out is not None:
        click.echo(f"Next: seamark run currents-v3 --controller pi --set current_record={out}")


def _made(source: Path, options: dict[str, Any]) -> tuple[Series, Made]:
    """Return what was read, and the record; raises CurrentRefused, RecordInvalid."""
    from seamark.current_data.reading import read
    from seamark.current_data.series import CurrentRefused, cut, record_of
    from seamark.current_data.tides import predicted, read_constituents

    if options["tides"]:
        begin, hours = _begin(options["begin"]), _hours(options["hours"])
        series = predicted(
            read_constituents(source),
            begin=begin,
            hours=hours,
            latitude_deg=options["latitude"],
            height_m=options["height"],
        )
    else:
        length_s = None if options["hours"] is None else 3600.0 * options["hours"]
        series = read(source)
        if series.times.size == 0:
            raise CurrentRefused("The file has no instants.")
        series = cut(series, first_s=3600.0 * options["first_h"], length_s=length_s)
    notes = {
        "title": options["title"] or source.stem,
        "begins": series.begins,
        "licence": options["licence"],
    }
    kept = {name: " ".join(text.split())[:300] for name, text in notes.items() if text}
    step_s, bottom_m = options["step_s"], options["bottom_m"]
    return series, record_of(series, bottom_m=bottom_m, step_s=step_s, notes=kept)


def _begin(text: str | None) -> datetime:
    try:
        moment = datetime.fromisoformat(text or "")
    except ValueError:
        raise UsageRefused("--tides needs --begin with a date, as in 2026-05-01T00:00.") from None
    return moment if moment.tzinfo else moment.replace(tzinfo=UTC)


def _hours(hours: float | None) -> float:
    most = 24.0 * 60.0
    if hours is None or not 0.0 < hours <= most:
        raise UsageRefused(f"--tides needs --hours, of at most {most:g}.")
    return hours


def _document(series: Series, made: Made) -> dict[str, Any]:
    import numpy as np

    record, gaps = made.record, made.gaps
    speed = np.hypot(record.velocity[:, 0], record.velocity[:, 1])
    mean = record.velocity.mean(axis=2)
    return {
        "layout": series.layout,
        "begins": series.begins,
        "hours": record.duration_s / 3600.0,
        "step_s": record.step_s,
        "heights_m": record.heights.tolist(),
        "mean_speed_m_s": speed.mean(axis=1).tolist(),
        "largest_speed_m_s": float(speed.max()),
        "mean_m_s": {"north": mean[:, 0].tolist(), "east": mean[:, 1].tolist()},
        "missing": gaps.missing,
        "filled_samples": gaps.filled,
        "instants_cut": gaps.cut,
        "levels_dropped_m": list(gaps.dropped),
        "said": list(made.said),
    }


def _lines(series: Series, made: Made) -> list[str]:
    from seamark.current_data.series import GAP_MAX, MISSING_MAX

    told, gaps = _document(series, made), made.gaps
    heights = ", ".join(f"{one:g}" for one in told["heights_m"])
    means = ", ".join(f"{one:.3f}" for one in told["mean_speed_m_s"])
    lines = [
        f"read as   {series.layout}" + (f", from {series.begins}" if series.begins else ""),
        f"span      {told['hours']:.2f} h, an instant every {told['step_s']:g} s",
        f"heights   {heights} m above the bottom",
        f"speed     mean {means} m/s, at most {told['largest_speed_m_s']:.3f} m/s",
        f"gaps      {gaps.missing:.1%} missing; {gaps.filled} samples filled linearly, in gaps of "
        f"at most {GAP_MAX}; {gaps.cut} instants cut off at longer ones",
    ]
    if gaps.dropped:
        dropped = ", ".join(f"{one:g}" for one in gaps.dropped)
        lines.append(f"left out  {dropped} m, of which more than {MISSING_MAX:.0%} is missing")
    return lines + [f"note      {text}" for text in made.said]


def _refuse_names(out: Path | None, drawing: Path | None) -> None:
    if out is not None and out.suffix.lower() != ".csv":
        raise UsageRefused(f"{out}: a record is a CSV file; give it a name with .csv.")
    if out is not None and out.exists():
        raise UsageRefused(f"{out} exists: choose another file, or remove it.")
    if drawing is not None and drawing.suffix.lower() != ".svg":
        raise UsageRefused(f"{drawing}: drawings are SVG; give the file a name with .svg.")


def _write(content: bytes, path: Path) -> None:
    from seamark.cli.output_folder import draft_of

    with draft_of(path) as file:
        file.write(content)


def _printable(text: str) -> str:
    from seamark.sandbox.printable_text import printable_text

    return printable_text(text)
