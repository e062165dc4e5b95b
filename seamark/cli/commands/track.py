"""`seamark track`: a target in a person's own video."""

from __future__ import annotations

from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import print_json
from seamark.cli.options import configuration_options, json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from seamark.trackers import Found

HEAD = ("image", "t", *(f"{axis}{k}" for k in range(4) for axis in "xy"), "ok", "residual")
CORNERS = 4
USUAL_RATE = 25.0  # [1/s] of a drawn video whose source does not say


@click.command()
@click.argument("video", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--corners",
    "text",
    metavar='"X,Y X,Y X,Y X,Y"',
    required=True,
    help="The target's corners in the first image [px], clockwise.",
)
@click.option("--tracker", default="esm", show_default=True, help="Which tracker.")
@click.option(
    "--first",
    type=click.IntRange(0),
    default=0,
    show_default=True,
    metavar="N",
    help="The image with these corners.",
)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.csv",
    required=True,
    help="File for the corners in each image; it must not exist.",
)
@click.option(
    "--drawn",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE.mp4",
    help="Also write the video with the tracker's box; it must not exist.",
)
@configuration_options
@json_option
def track(  # noqa: PLR0913  # one per option
    *,
    video: Path,
    text: str,
    tracker: str,
    first: int,
    out: Path,
    drawn: Path | None,
    config: Path | None,
    pairs: tuple[str, ...],
    as_json: bool,
) -> None:
    """Follow a plane target through your own video.

    VIDEO is a file that OpenCV reads. The rows of the CSV file have the number of the image, its
    time [s], the four corners x0 y0 to x3 y3 [px], whether the tracker has the target (ok) and how
    badly it matches (residual, 0 to 2). --set gives options of the tracker, as in a benchmark's
    configuration; docs/trackers.md explains them.

    \b
    Examples:
      seamark track dive.mp4 --corners "211,98 302,101 300,131 209,128" --out dive.csv
      seamark track dive.mp4 --corners "211,98 302,101 300,131 209,128" --out dive.csv \\
        --set warp=affine --drawn dive_tracked.mp4
    """
    from seamark.cli.output_folder import draft_of

    _refuse_outputs(out, drawn)
    images = held = 0
    with ExitStack() as files:
        table = files.enter_context(draft_of(out))
        table.write(_line(HEAD))
        draw = files.enter_context(_drawing(drawn, video)) if drawn else None
        try:
            for found in _found(video, text, tracker, first, config, pairs):
                images, held = images + 1, held + found.ok
                table.write(_line(_row(found)))
                if draw is not None:
                    draw(found)
        except ValueError as reason:
            raise UsageRefused(f"{video}: {str(reason).rstrip('.')}.") from None
    if as_json:
        print_json({"images": images, "held": held, "out": str(out)})
    else:
        click.echo(f"{held} of {images} images with the target. {out} written.")


def _refuse_outputs(out: Path, drawn: Path | None) -> None:
    for path in (out, drawn):
        if path is not None and path.exists():
            raise UsageRefused(f"{path} exists: choose another file, or remove it.")
    if drawn is not None and drawn.suffix.lower() != ".mp4":
        raise UsageRefused(f"{drawn}: give the video a name with .mp4.")


def _found(
    video: Path, text: str, tracker: str, first: int, config: Path | None, pairs: tuple[str, ...]
) -> Iterator[Found]:
    from seamark.cli.configuration import read_settings, typed
    from seamark.sim.settings.setting import property_of
    from seamark.sim.trackers import option_names
    from seamark.trackers import DEFAULTS
    from seamark.trackers import track as found_in

    types = {name: property_of(name, DEFAULTS[name]) for name in option_names(tracker)}
    options = typed(read_settings(config, pairs), {"properties": types})
    return found_in(video, _corners(text), tracker=tracker, first=first, **options)


def _corners(text: str) -> list[list[float]]:
    try:
        corners = [[float(number) for number in pair.split(",")] for pair in text.split()]
    except ValueError:
        corners = []
    if [len(pair) for pair in corners] != [2] * CORNERS:
        raise UsageRefused(
            f"--corners {text}: write four points, such as 211,98 302,101 300,131 209,128."
        )
    return corners


def _row(found: Found) -> Iterator[str]:
    yield from (str(found.number), f"{found.time_s:.4f}")
    yield from (f"{number:.3f}" for number in found.corners.ravel().tolist())
    yield from (str(int(found.ok)), f"{found.residual:.4f}")


def _line(cells: Iterable[str]) -> bytes:
    return (",".join(cells) + "\n").encode()


@contextmanager
def _drawing(path: Path, video: Path) -> Iterator[Callable[[Found], None]]:
    """Provide what draws the tracker's box into a video: green, red at its last place if lost.

    The rate is that of the video; what was not finished is removed.
    """
    import cv2
    import numpy as np

    source = cv2.VideoCapture(str(video))
    rate = source.get(cv2.CAP_PROP_FPS) or USUAL_RATE
    source.release()
    writer = cv2.VideoWriter()

    def draw(found: Found) -> None:
        image = found.image.copy()
        if not writer.isOpened():
            code, size = cv2.VideoWriter.fourcc(*"mp4v"), (image.shape[1], image.shape[0])
            if not writer.open(str(path), code, rate, size):
                raise UsageRefused(f"{path} cannot be written.")
        box = np.round(found.corners).astype(np.int32)[:, None]
        cv2.polylines(image, [box], True, (0, 255, 0) if found.ok else (0, 0, 255), 2)
        writer.write(image)

    try:
        yield draw
    except BaseException:
        writer.release()
        path.unlink(missing_ok=True)
        raise
    writer.release()
