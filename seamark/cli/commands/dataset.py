"""`seamark dataset`: images with ground truth, rendered from a configuration and a seed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.configuration import configuration_of
from seamark.cli.console import print_json
from seamark.cli.options import benchmark_argument, configuration_options, json_option
from seamark.cli.output_folder import draft_of
from seamark.failures import UsageRefused
from seamark.progress import Progress

if TYPE_CHECKING:
    from seamark.sim.recording.telemetry import Rows
    from seamark.sim.settings.configuration import Configuration


@click.command()
@benchmark_argument
@configuration_options
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@click.option(
    "--trial", type=click.IntRange(0), default=0, show_default=True, help="Which trial of a run."
)
@click.option(
    "--solution",
    metavar="NAME",
    help="The built-in solution that moves the vehicle.  [default: the benchmark's own]",
)
@click.option(
    "--every", type=click.IntRange(1), default=1, show_default=True, help="Keep one in N images."
)
@click.option("--from", "begin_s", type=click.FloatRange(0), default=0.0, help="Start time [s].")
@click.option("--until", "end_s", type=click.FloatRange(0), help="End time [s].  [default: end]")
@click.option(
    "--format",
    "layout",
    type=click.Choice(["seamark", "coco", "yolo", "tum"]),
    default="seamark",
    show_default=True,
    help="For which programs: Seamark's own layout has everything.",
)
@click.option("--colour", is_flag=True, help="Colour images instead of the trackers' grey ones.")
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    default=Path("dataset.zip"),
    show_default=True,
    metavar="FILE.zip",
)
@json_option
def dataset(  # noqa: PLR0913 (one argument per option is click's way)
    *,
    benchmark: str,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int,
    trial: int,
    solution: str | None,
    every: int,
    begin_s: float,
    end_s: float | None,
    layout: str,
    colour: bool,
    out: Path,
    as_json: bool,
) -> None:
    """Write a data set: the images of a trial with poses, corners, intrinsics and water.

    The images are those of the benchmark, and the same options give the same bytes.

    \b
    Examples:
      seamark dataset currents-v2 --set levels=0.2 --seed 7 --out currents.zip
      seamark dataset visibility-v2 --every 4 --colour --out murky.zip
      seamark dataset visibility-v2 --every 20 --format coco --out coco.zip
    """
    from seamark.cli.simulator_loading import loading_shown
    from seamark.sim.engine.dataset import Selection, archive

    checked = configuration_of(benchmark, config, pairs)
    with Progress(f"{benchmark}, seed {seed}", quiet=as_json) as bar, loading_shown(bar):
        rows = _rows(benchmark, checked, solution, seed=seed, trial=trial, show=bar.show)
    end = float("inf") if end_s is None else end_s
    selection = Selection(every=every, begin_s=begin_s, end_s=end, colour=colour)
    try:
        pieces = archive(benchmark, checked, rows, seed=seed, selection=selection, layout=layout)
    except ValueError as error:
        raise UsageRefused(f"{error}. Check --from, --until and --every.") from None
    count = len(selection.of(rows))
    with Progress(f"{count} images", quiet=as_json) as bar:
        size = _write(pieces, out, lambda done: bar.show(min(done / count, 1.0)))
    if as_json:
        print_json({"out": str(out), "pictures": count, "bytes": size, "seed": seed})
    else:
        click.echo(f"{count} images, {size / 2**20:.1f} MiB: {out}")


def _rows(
    benchmark: str,
    config: Configuration,
    solution: str | None,
    *,
    seed: int,
    trial: int,
    show: Callable[[float], None],
) -> Rows:
    """Return the telemetry of one trial with a built-in solution."""
    import numpy as np

    from seamark.sim import registry
    from seamark.sim.engine.trial import run_trial
    from seamark.sim.recording.telemetry import INDEX

    entry = registry.benchmark(benchmark)
    known = list(entry.built_in)
    name = known[0] if solution is None else solution
    if name not in known:
        raise UsageRefused(f"There is no built-in solution {name}. Available: {', '.join(known)}.")
    rows: list[Rows] = []
    duration_s = entry.trial_duration_s(config)

    def keep(some: Rows) -> None:
        rows.append(some.copy())
        show(some[-1, INDEX["t"]] / duration_s)

    run_trial(
        benchmark,
        config,
        entry.load().built_in(name, config),
        seed=seed,
        trial=trial,
        on_rows=keep,
    )
    show(1.0)
    return np.concatenate(rows)


def _write(pieces: Iterator[bytes], out: Path, show: Callable[[int], None]) -> int:
    """Write the archive and return its size."""
    size = 0
    with draft_of(out) as file:
        for number, piece in enumerate(pieces):
            size += file.write(piece)
            show(number)
    return size
