"""Many mechanisms of one structure: vehicles with arms that touch things, eight side by side.

Each has its own numbers, state, water and time; the bits are those of one that moves alone
(`multibody.step.advance`).
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from seamark.sim.fleet.blocks import SPACING, TOP, water_of
from seamark.sim.fleet.tables import WATER_NUMBERS
from seamark.sim.multibody.mechanism import command_for, state_for, work_for
from seamark.sim.multibody.solver import Timing
from seamark.sim.multibody.step import Command, Model, State, Work, take_step
from seamark.sim.multibody.tree import WORLD, Structure, place
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.borrowed import borrowed
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.lanes import LANES, lanes_of
from seamark.sim.physics.current import RELATIVE, TABLE, Current, segment_at
from seamark.sim.physics.terrain import Mounds


class _Stream(NamedTuple):
    """The water of eight mechanisms."""

    numbers: Array  # (WATER_NUMBERS, 8)
    drift: Array  # (8, rows, grid)
    law: int
    middle: Array  # (1, 8) [s] of the step
    first: Array  # (1, 8) steps since the beginning


class Mechanisms:
    """n mechanisms that move in steps of the same length, over one ground.

    Raises
    ------
    ValueError
        Their structures differ, a current follows the force law, or laws, lengths or depths of
        currents differ.
    """

    def __init__(
        self,
        models: Sequence[Model],
        currents: Sequence[Current],
        ground: Mounds,
        timing: Timing,
        *,
        threads: int = 1,
    ) -> None:
        """Put all of them at rest, with all coordinates zero."""
        self.count = len(models)
        filled = [*models, *[models[-1]] * (-len(models) % LANES)]
        waters = [current.water for current in currents]
        waters += [waters[-1]] * (len(filled) - len(waters))
        laws = {water.law for water in waters}
        if not laws <= {RELATIVE, TABLE} or len(laws) > 1:
            raise ValueError("mechanisms need currents of the relative law, or of tables alone")
        if len({water.drift.shape for water in waters}) > 1:
            raise ValueError("the currents of one fleet must have the same length and depths")
        self._ground, self._timing = ground, timing
        blocks = range(0, len(filled), LANES)
        self._models = [_side_by_side(filled[at : at + LANES]) for at in blocks]
        self._streams = [_stream(waters[at : at + LANES]) for at in blocks]
        self._states = [state_for(models[0], (LANES,)) for _ in blocks]
        self._commands = [command_for(models[0], (LANES,)) for _ in blocks]
        self._works = [work_for(models[0], (LANES,)) for _ in blocks]
        self._advance = SameTypes(advance_block)
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def place(self, i: int, state: State, *, step: int = 0) -> None:
        """Give mechanism i a state, that of a number of steps since its beginning."""
        block, lane = divmod(i, LANES)
        _copy(state, self._states[block], lane)
        self._streams[block].first[0, lane] = step

    def read(self, i: int, out: State) -> None:
        """Copy the state of mechanism i."""
        block, lane = divmod(i, LANES)
        _copy(self._states[block], out, lane)

    def advance(self, steps: int, thrust: Array, speed: Array) -> None:
        """Move all of them by a number of steps.

        Parameters
        ----------
        thrust : (n, m) [N]
            Steady thrust of each thruster.
        speed : (n, a) [rad/s or m/s]
            Wanted speed of each motor.
        """
        for i in range(self.count):
            block, lane = divmod(i, LANES)
            self._commands[block].thrust[:, lane] = thrust[i]
            self._commands[block].speed[:, lane] = speed[i]

        def move(block: int) -> None:
            self._advance.call(
                steps,
                self._timing,
                self._models[block],
                self._states[block],
                self._commands[block],
                self._streams[block],
                self._ground,
                self._works[block],
            )

        blocks = range(len(self._models))
        if self._pool is None:
            for block in blocks:
                move(block)
        else:
            list(self._pool.map(move, blocks))

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()


def _stream(waters: Sequence[Any]) -> _Stream:
    return _Stream(
        numbers=np.array([[float(getattr(w, n)) for w in waters] for n in WATER_NUMBERS]),
        drift=np.array([water.drift for water in waters]),
        law=waters[0].law,
        middle=np.zeros((1, LANES)),
        first=np.zeros((1, LANES)),
    )


def _side_by_side(parts: Sequence[Any]) -> Any:
    """Return nested tuples of arrays as one: float64 (...,) as (..., 8), integers once.

    Raises
    ------
    ValueError
        Their integers differ.
    """
    first = parts[0]
    if isinstance(first, tuple):
        return type(first)(*(_side_by_side(group) for group in zip(*parts, strict=True)))
    if first.dtype == np.float64:
        return np.ascontiguousarray(np.stack(parts, axis=-1))
    if not all(np.array_equal(first, part) for part in parts):
        raise ValueError("the mechanisms of one fleet must have the same structure")
    return first


def _copy(source: Any, target: Any, lane: int) -> None:
    """Copy nested arrays between a single mechanism and a lane; the one with fewer axes is it."""
    if isinstance(source, tuple):
        for one, other in zip(source, target, strict=True):
            _copy(one, other, lane)
    elif source.ndim < target.ndim:
        target[..., lane] = source
    else:
        target[...] = source[..., lane]


@njit(cache=True, nogil=True, error_model="numpy")
def advance_block(
    steps: int,
    timing: Timing,
    model: Model,
    state: State,
    command: Command,
    stream: _Stream,
    ground: Mounds,
    work: Work,
) -> None:
    """Advance eight mechanisms by a number of steps, each from its own time on."""
    stream = borrowed(stream)
    models, states = lanes_of(borrowed(model)), lanes_of(borrowed(state))
    work = borrowed(work)
    commands, works = lanes_of(borrowed(command)), lanes_of(work)
    middle = lanes_of(stream.middle)
    water = water_of(lanes_of(stream.numbers), stream.law, stream.drift[0])
    for _ in range(steps):
        place(models.structure, models.links, states.q, works.frames)
        for lane in range(LANES):
            stream.middle[0, lane] = stream.first[0, lane] * timing.step_s + 0.5 * timing.step_s
            _choose_segments(lane, models.structure, stream, work)
            stream.first[0, lane] += 1.0
        take_step(middle[0], timing, models, states, commands, water, ground, works)


@njit(cache=True, error_model="numpy", inline="always")
def _choose_segments(lane: int, structure: Structure, stream: _Stream, work: Work) -> None:
    """Write the segments of the water around one mechanism, as `step.place_in_water`."""
    grid, frames = (stream.numbers[TOP, lane], stream.numbers[SPACING, lane]), work.frames
    for i in range(structure.parent.size):
        if structure.parent[i] == WORLD:
            t, depth = stream.middle[0, lane], frames.position[i, 2, lane]
            segment = segment_at(t, depth, stream.law, grid, stream.drift[lane])
            for j in range(len(segment)):
                frames.segment[i, j, lane] = segment[j]
