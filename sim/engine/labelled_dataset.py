"""Data sets to train detectors with: as many images as asked for, drawn anew.

The bytes of an archive depend on configuration, seed, number of images and layout alone. It is
written as its images come, in memory that does not grow with their number but for the directory at
the end of the archive, which has a line for each file.
"""

from collections.abc import Iterator
from itertools import chain
from typing import Any

from seamark.sim.engine.archive_writing import Member, json_file, png, zipped
from seamark.sim.engine.labelled_images import LabelledImage, LabelledScenes, labelled_images
from seamark.sim.engine.labelled_layouts import LABELLED_LAYOUTS, LabelledLayout
from seamark.sim.recording.manifest import code_sha256, versions

MOST_IMAGES = 200_000  # in an archive: its directory then takes some 200 MB of memory


def labelled_archive(
    benchmark: str,
    experiment: LabelledScenes,
    config: Any,
    *,
    seed: int,
    count: int,
    layout: str,
) -> Iterator[bytes]:
    """Return a ZIP archive in pieces.

    Parameters
    ----------
    seed
        Not negative; data sets of different seeds have no scene in common.
    count
        How many images.
    layout
        One of `LABELLED_LAYOUTS`: whose programs are to read it.
    """
    command = (
        f"seamark dataset {benchmark} --config configuration.json --images {count} --seed {seed} "
        f"--format {layout}"
    )
    about = {
        "benchmark": benchmark,
        "images": count,
        "seed": seed,
        "code_sha256": code_sha256(),
        "versions": versions(),
    }
    depths = config.level_values()
    text = LABELLED_LAYOUTS[layout].readme.format(
        benchmark=benchmark,
        count=count,
        colours="colour" if config.colour else "grey",
        per_scene=experiment.images_per_scene,
        shallow=depths[0],
        deep=depths[-1],
        command=command,
    )
    fixed = {
        "README.md": text.encode(),
        "configuration.json": json_file(config.model_dump(mode="json")),
        "manifest.json": json_file(about),
    }
    images = labelled_images(experiment, config, seed=seed, count=count)
    return zipped(chain(fixed.items(), _members(LABELLED_LAYOUTS[layout](), images)))


def _members(layout: LabelledLayout, images: Iterator[LabelledImage]) -> Iterator[Member]:
    for number, labelled in enumerate(images):
        name = f"{number:06d}.png"
        yield f"images/{name}", png(labelled.image)
        yield from layout.add(name, labelled)
    yield from layout.end()
