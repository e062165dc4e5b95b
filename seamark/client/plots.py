"""A run as a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seamark.client import tables

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

SIZE_IN = (9.0, 5.0)


def figure(rows: NDArray[np.void], *, title: str) -> Figure:
    """Return a figure with the distance from the station, the current, and the path from above.

    All trials are drawn over each other.

    Raises
    ------
    PackageMissing
        Matplotlib is not installed.
    """
    numpy = tables.package("numpy")
    drawn: Figure = tables.package("matplotlib.figure").Figure(SIZE_IN, layout="constrained")
    axes = drawn.subplot_mosaic([["distance", "path"], ["current", "path"]], width_ratios=[3, 2])
    for trial in numpy.unique(rows["trial"]):
        part = rows[rows["trial"] == trial]
        speed = numpy.hypot(numpy.hypot(part["current_x"], part["current_y"]), part["current_z"])
        axes["distance"].plot(part["t"], part["distance"], linewidth=1.0)
        axes["current"].plot(part["t"], speed, linewidth=1.0)
        axes["path"].plot(part["y"], part["x"], linewidth=0.8)
    axes["distance"].set_ylabel("Distance from station [m]")
    axes["current"].set(xlabel="Time [s]", ylabel="Current [m/s]")
    axes["path"].set(xlabel="East [m]", ylabel="North [m]", aspect="equal")
    drawn.suptitle(title)
    return drawn
