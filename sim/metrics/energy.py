"""Energy and power of thrusters, as every benchmark with thrusters has them."""

from typing import Any, Protocol

import numpy as np

from seamark.sim.metrics.metric import SUM, LevelMetric
from seamark.sim.metrics.windows import THRUST_COLUMNS, Window
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.exact_sums import exact_mean, exact_sum

ENERGY_EXPONENT = 1.5  # ideal propeller: power grows with the thrust to the power of 1.5


class Thrusting(Protocol):
    """The rows of a level."""

    dt: float  # [s]

    @property
    def thrust(self) -> Array:
        """Thrust of each thruster, (k, n) [N]."""


def _energy(level: Thrusting) -> float:
    size = np.abs(level.thrust)
    return exact_sum(size * np.sqrt(size)) * level.dt


def power_share(level: Window) -> float:
    """Return the mean power of the thrusters, relative to all of them at full thrust."""
    forward, reverse = level.facts.limits_n
    thrust = level.thrust[:, : level.facts.thrusters]
    share = np.where(thrust > 0.0, thrust / forward, -thrust / reverse)
    return exact_mean(share * np.sqrt(share))


ENERGY: LevelMetric[Any] = LevelMetric(
    name="energy_n15_s",
    label=f"Energy proxy, integral of thrust^{ENERGY_EXPONENT:g}",
    unit=f"N^{ENERGY_EXPONENT:g} s",
    better="lower",
    meaning=f"the power of an ideal propeller grows with thrust^{ENERGY_EXPONENT:g}",
    formula=f"sum over control steps and thrusters of abs(thrust)^{ENERGY_EXPONENT:g} dt",
    over=SUM,
    reads=THRUST_COLUMNS,
    compute=_energy,
)
POWER: LevelMetric[Any] = LevelMetric(
    name="power_share",
    label="Power",
    unit="",
    better="lower",
    meaning="relative to all thrusters at full thrust",
    formula="mean over control steps and thrusters of (abs(thrust) / its limit)^1.5",
    reads=THRUST_COLUMNS,
    compute=power_share,
)
