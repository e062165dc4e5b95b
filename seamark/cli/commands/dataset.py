"""`seamark dataset`: images with ground truth, rendered from a configuration and a seed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click
from click.core import ParameterSource

from seamark.cli.configuration import benchmark_of, configuration_of
from seamark.cli.console import print_json
from seamark.cli.options import benchmark_argument, configuration_options, json_option
from seamark.cli.output_folder import draft_of
from seamark.failures import UsageRefused
from seamark.progress import Progress

if TYPE_CHECKING:
    from seamark.sim.engine.labelled_images import LabelledScenes
    from seamark.sim.recording.telemetry import Rows
    from seamark.sim.settings.configuration import Configuration

_OF_A_TRIAL = ("--trial", "--solution", "--every", "--from", "--until")
_FOR_TRACKERS = frozenset({"seamark", "coco", "yolo", "tum"})  # formats
_FOR_DETECTORS = frozenset({"coco", "yolo", "csv"})


@click.command()
@benchmark_argument
@configuration_options
@click.option(
    "--images",
    "count",
    type=click.IntRange(1),
    metavar="N",
    help="How many images to train a detector with, drawn anew; for patterns-v1.",
)
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
    type=click.Choice(["seamark", "coco", "yolo", "tum", "csv"]),
    help="For which programs; csv with --images only.  [default: seamark, which has everything, or "
    "csv with --images]",
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
@click.pass_context
def dataset(  # noqa: PLR0913 (one argument per option is click's way)
    context: click.Context,
    *,
    benchmark: str,
    pairs: tuple[str, ...],
    config: Path | None,
    count: int | None,
    seed: int,
    trial: int,
    solution: str | None,
    every: int,
    begin_s: float,
    end_s: float | None,
    layout: str | None,
    colour: bool,
    out: Path,
    as_json: bool,
) -> None:
    """Write a data set: the images of a trial with poses, corners, intrinsics and water.

    The images are those of the benchmark, and the same options give the same bytes. For patterns-v1
    it writes images to train a detector with instead, of bottoms that no run shows, and what is
    seen in each.

    \b
    Examples:
      seamark dataset currents-v3 --set levels=0.2 --seed 7 --out currents.zip
      seamark dataset visibility-v3 --every 4 --colour --out murky.zip
      seamark dataset visibility-v3 --every 20 --format coco --out coco.zip
      seamark dataset patterns-v1 --images 2000 --format coco --out patterns.zip
    """
    detectors = benchmark_of(benchmark).role == "detector"
    _refuse_what_does_not_apply(context, benchmark, detectors=detectors)
    checked = configuration_of(benchmark, config, pairs)
    if count is not None:
        pieces = _drawn_anew(
            benchmark, checked, layout, seed=seed, count=count, colour=colour, quiet=as_json
        )
    else:
        end = float("inf") if end_s is None else end_s
        choice = {"every": every, "begin_s": begin_s, "end_s": end, "colour": colour}
        pieces, count = _of_a_trial(
            benchmark, checked, layout, solution, choice, seed=seed, trial=trial, quiet=as_json
        )
    images = count
    with Progress(f"{images} images", quiet=as_json) as bar:
        size = _write(pieces, out, lambda done: bar.show(min(done / images, 1.0)))
    if as_json:
        print_json({"out": str(out), "pictures": images, "bytes": size, "seed": seed})
    else:
        click.echo(f"{images} images, {size / 2**20:.1f} MiB: {out}")


def _refuse_what_does_not_apply(context: click.Context, benchmark: str, *, detectors: bool) -> None:
    """Refuse a benchmark without images, and options of the other kind of benchmark."""
    why = benchmark_of(benchmark).lacks_images
    if why:
        raise UsageRefused(f"{benchmark} has no data set: {why}.")
    given = [
        option.opts[0]
        for option in context.command.params
        if option.name is not None
        and context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE
    ]
    layout = context.params["layout"]
    if not detectors:
        if "--images" in given or layout in _FOR_DETECTORS - _FOR_TRACKERS:
            raise UsageRefused(
                f"--images and --format csv are for detectors: {benchmark} has none. "
                "Its images are those of a trial."
            )
        return
    if "--images" not in given:
        raise UsageRefused(f"Say with --images how many images of {benchmark} you want.")
    if wrong := [option for option in given if option in _OF_A_TRIAL]:
        raise UsageRefused(
            f"{', '.join(wrong)} selects images of a trial; those of {benchmark} are drawn anew."
        )
    if layout is not None and layout not in _FOR_DETECTORS:
        known = ", ".join(sorted(_FOR_DETECTORS))
        raise UsageRefused(f"{benchmark} has no format {layout}. Available: {known}.")


def _drawn_anew(
    benchmark: str,
    config: Configuration,
    layout: str | None,
    *,
    seed: int,
    count: int,
    colour: bool,
    quiet: bool,
) -> Iterator[bytes]:
    """Return the pieces of an archive of images to train a detector with."""
    from seamark.cli.simulator_loading import loading_shown

    with Progress(f"{benchmark}, seed {seed}", quiet=quiet) as bar, loading_shown(bar):
        from seamark.sim.engine.labelled_dataset import MOST_IMAGES, labelled_archive

        experiment = cast("LabelledScenes", benchmark_of(benchmark).load())
    if count > MOST_IMAGES:
        raise UsageRefused(
            f"An archive has at most {MOST_IMAGES} images, not {count}: make several, each with "
            "another --seed."
        )
    if colour:
        config = config.model_copy(update={"colour": True})
    return labelled_archive(
        benchmark, experiment, config, seed=seed, count=count, layout=layout or "csv"
    )


def _of_a_trial(
    benchmark: str,
    config: Configuration,
    layout: str | None,
    solution: str | None,
    choice: Mapping[str, Any],
    *,
    seed: int,
    trial: int,
    quiet: bool,
) -> tuple[Iterator[bytes], int]:
    """Return the pieces of an archive of images of a trial, and how many images it has."""
    from seamark.cli.simulator_loading import loading_shown
    from seamark.sim.engine.dataset import SEAMARK, Selection, archive

    with Progress(f"{benchmark}, seed {seed}", quiet=quiet) as bar, loading_shown(bar):
        rows = _rows(benchmark, config, solution, seed=seed, trial=trial, show=bar.show)
    selection = Selection(**choice)
    try:
        pieces = archive(
            *(benchmark, config, rows), seed=seed, selection=selection, layout=layout or SEAMARK
        )
    except ValueError as error:
        raise UsageRefused(f"{error}. Check --from, --until and --every.") from None
    return pieces, len(selection.of(rows))


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
        entry.load().built_in(name, config.for_trial(trial)),
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
