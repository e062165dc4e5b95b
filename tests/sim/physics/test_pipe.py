"""A pipe on the seabed: arc lengths, and where sand covers it."""

import numpy as np
import pytest

from seamark.sim.physics.pipe import RAMP_M, pipe_along, sand_on

BENT = np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 6.0]])


def test_arc_lengths_are_those_of_the_straight_pieces() -> None:
    assert pipe_along(BENT, 20.0, 0.2, seed=1).starts_m.tolist() == [0.0, 5.0, 7.0]


def test_sand_covers_a_stretch_and_falls_off_beside_it() -> None:
    pipe = pipe_along(BENT, 20.0, 0.2, seed=1)._replace(covered_m=np.array([[2.0, 3.0]]))

    heights = [sand_on(pipe, along) for along in (2.0, 2.5, 3.0)]

    assert min(heights) >= 1.0
    assert sand_on(pipe, 2.0 - 0.5 * RAMP_M) == pytest.approx(0.5)
    assert sand_on(pipe, 3.0 + RAMP_M) == pytest.approx(0.0, abs=1e-12)
    assert sand_on(pipe, 6.0) == 0.0
