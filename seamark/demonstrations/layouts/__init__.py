"""The layouts by name: what they are called, and what writes them. Importing this is light."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from seamark.demonstrations.description import Description
    from seamark.demonstrations.episodes import Images, Outcome


class Episode(NamedTuple):
    """An episode as layouts get it: what came of it, its numbers and its packed images."""

    outcome: Outcome
    arrays: Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """A layout of demonstrations; `module` has `refusal`, `packed_images` and `write`."""

    name: str
    label: str
    module: str
    dtype: str  # of observations and actions, unless another one is asked for
    packages: tuple[str, ...]  # as `import` calls them

    def refusal(self, description: Description) -> str:
        """Return why demonstrations cannot have this layout; empty if they can."""
        why: str = importlib.import_module(self.module).refusal(description)
        return why

    def packed_images(self, images: Mapping[str, Images], rate_hz: float) -> dict[str, Any]:
        """Return images as they are kept until the whole set is written: arrays by name."""
        packed: dict[str, Any] = importlib.import_module(self.module).packed_images(images, rate_hz)
        return packed

    def write(self, description: Description, episodes: Iterable[Episode], folder: Path) -> None:
        """Write a set of demonstrations into an empty folder, one episode after the other."""
        importlib.import_module(self.module).write(description, episodes, folder)


_ALL = (
    Layout(
        name="lerobot",
        label="LeRobot data set v3, with MP4 for images",
        module="seamark.demonstrations.layouts.lerobot",
        dtype="float32",
        packages=("av", "gymnasium", "pyarrow"),
    ),
    Layout(
        name="minari",
        label="HDF5 as Minari reads it",
        module="seamark.demonstrations.layouts.minari",
        dtype="float64",
        packages=("gymnasium", "h5py"),
    ),
    Layout(
        name="parquet",
        label="plain Parquet, with PNG for images",
        module="seamark.demonstrations.layouts.parquet",
        dtype="float64",
        packages=("gymnasium", "pyarrow"),
    ),
)
LAYOUTS = {layout.name: layout for layout in _ALL}
