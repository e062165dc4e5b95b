"""Acoustic positioning by an ultra-short baseline (USBL): range and direction from a transceiver.

A transceiver under a boat pings; the vehicle's beacon answers. Range and direction of the answer
give a position, which reaches the vehicle by the acoustic link some time later.
"""

import math
from dataclasses import dataclass

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import atan2, sincos

SOUND_M_S = 1500.0  # S: sea water, Urick 1983, ch. 5; 1,450 to 1,550


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """How well a transceiver measures, and how often."""

    period_steps: int  # control steps from one ping to the next
    delay_s: float  # from the answer to when the vehicle has the position
    range_sigma_m: float
    angle_sigma_rad: float  # of bearing and elevation
    dropout: float  # share of the pings without a position


@dataclass(frozen=True, slots=True, kw_only=True)
class Fix:
    """A position as the system reports it."""

    position_m: Array  # (3,) NED
    at_step: int  # control step of the ping that it is of
    sigma_m: float  # standard deviation of each of north and east, on average over both
    range_m: float
    bearing_rad: float  # from north, clockwise
    elevation_rad: float  # downwards from the horizon


class Usbl:
    """The positions that a vehicle gets over a level."""

    def __init__(
        self,
        rng: np.random.Generator,
        noise: Noise,
        transceiver_m: Array,
        *,
        steps: int,
        step_s: float,
    ) -> None:
        """Draw the noise of all pings of a level of `steps` control steps of `step_s`."""
        pings = steps // noise.period_steps + 1
        # Normal numbers for range, bearing and elevation, and one in [0, 1) for the drop-out: as
        # many whatever the settings, so that changing one leaves all other draws unchanged.
        self._normals, self._shares = rng.standard_normal((pings, 3)), rng.random(pings)
        self._noise, self._transceiver, self._step_s = noise, transceiver_m, step_s
        self._under_way: list[tuple[int, Fix]] = []  # the step of arrival of each
        self.last: Fix | None = None

    def step(self, step: int, position_m: Array, *, heard: bool = True) -> None:
        """Ping if it is time, and take what arrives; `position_m` is the beacon's, (3,) NED.

        `heard` is whether its answer to a ping of now can be told from echoes.
        """
        ping, since = divmod(step, self._noise.period_steps)
        if since == 0 and heard and self._shares[ping] >= self._noise.dropout:
            fix = self._measured(step, position_m, self._normals[ping].tolist())
            late_s = self._noise.delay_s + 2.0 * fix.range_m / SOUND_M_S
            self._under_way.append((step + max(round(late_s / self._step_s), 0), fix))
        while self._under_way and self._under_way[0][0] <= step:
            self.last = self._under_way.pop(0)[1]

    def _measured(self, step: int, position_m: Array, normals: list[float]) -> Fix:
        noise = self._noise
        north, east, down = (position_m - self._transceiver).tolist()
        level = math.sqrt(north * north + east * east)
        distance = math.sqrt(level * level + down * down) + noise.range_sigma_m * normals[0]
        bearing = atan2(east, north) + noise.angle_sigma_rad * normals[1]
        elevation = atan2(down, level) + noise.angle_sigma_rad * normals[2]
        (sine, cosine), (fall, run) = sincos(bearing), sincos(elevation)
        offset = distance * np.array([run * cosine, run * sine, fall])
        across = distance * noise.angle_sigma_rad
        return Fix(
            position_m=self._transceiver + offset,
            at_step=step,
            sigma_m=math.sqrt(0.5 * (noise.range_sigma_m**2 + across * across)),
            range_m=distance,
            bearing_rad=bearing,
            elevation_rad=elevation,
        )
