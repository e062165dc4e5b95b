"""Sine and cosine of arrays, without compiled code."""

import subprocess
import sys

import numpy as np

from seamark.sim.numerics.elementwise import sincos
from seamark.sim.numerics.libm import PI


def test_they_agree_with_those_of_numpy_within_half_a_turn() -> None:
    angles = np.linspace(-PI, PI, 20001)

    sine, cosine = sincos(angles)

    assert np.abs(sine - np.sin(angles)).max() < 1e-14
    assert np.abs(cosine - np.cos(angles)).max() < 1e-14


def test_an_angle_gives_the_same_bits_alone_and_among_others() -> None:
    angles = np.linspace(-3.0, 3.0, 37)

    together = np.array(sincos(angles))
    alone = np.array([sincos(angles[i : i + 1]) for i in range(len(angles))])[:, :, 0].T

    assert together.tobytes() == np.ascontiguousarray(alone).tobytes()


def test_they_load_no_numba() -> None:
    program = "import sys, seamark.sim.numerics.elementwise; print('numba' in sys.modules)"

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )

    assert done.stdout.strip() == "False"
