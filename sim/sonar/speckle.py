"""From mean intensities to the image: speckle, beam pattern, noise, gain.

A resolution cell holds many scatterers with phases of their own, so that the field of its echo is a
complex normal number: its intensity is exponentially distributed, its amplitude is a Rayleigh
variable (Goodman 1976, JOSA 66(11), 1145-1150). A beam receives the fields of its neighbours as its
pattern weighs them, so speckle is as wide as the beam. The thermal noise of the elements passes
through the same pattern.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.raycast import noise_start
from seamark.sim.numerics.simd import (
    WIDTH,
    f32x16,
    load,
    minimum,
    sqrt,
    store,
    store_i32,
    to_i32,
)
from seamark.sim.numerics.uncounted import uncounted

Plane = NDArray[np.float32]


class Receiver(NamedTuple):
    """What turns echoes into an image."""

    pattern: NDArray[np.float32]  # (taps,) amplitude of a beam in its neighbours; 1 in its own
    loss: Plane  # (1, bins) share of the intensity that returns
    noise: float  # intensity before the pattern
    gain: Plane  # (1, bins) grey level of an amplitude of 1


class Fields(NamedTuple):
    """Memory of an image."""

    real: Plane  # (beams and those beyond both sides, bins)
    imaginary: Plane
    levels: NDArray[np.int32]  # (bins,)


@njit(cache=True, nogil=True, error_model="numpy")
def receive(
    echoes: Plane,
    receiver: Receiver,
    bank: Plane,
    key: tuple[int, int],
    fields: Fields,
    out: NDArray[np.uint8],
) -> None:
    """Write the image (bins, beams) of the mean intensities (beams and beyond, bins).

    `bank` is (1, n) of standard normal numbers, `key` the seed of the noise and the frame.
    """
    for beam in range(echoes.shape[0]):
        first = noise_start(key[0], key[1], beam, 0)
        second = noise_start(key[0], key[1], beam, 1)
        _scatter(echoes, beam, receiver, bank, (first, second), fields)
    for beam in range(out.shape[1]):
        _form(beam, receiver, fields)
        for j in range(out.shape[0]):
            out[j, beam] = np.uint8(fields.levels[j])


@uncounted
def _scatter(
    echoes: Plane,
    beam: int,
    receiver: Receiver,
    bank: Plane,
    starts: tuple[int, int],
    fields: Fields,
) -> None:
    """Write the field of one beam before the pattern."""
    half, noise = f32x16(0.5), f32x16(receiver.noise)  # of the intensity in each part
    for q in range(0, echoes.shape[1], WIDTH):
        mean = load(echoes, beam, q) * load(receiver.loss, 0, q) + noise
        deviation = sqrt(half * mean)
        store(fields.real, beam, q, deviation * load(bank, 0, starts[0] + q))
        store(fields.imaginary, beam, q, deviation * load(bank, 0, starts[1] + q))


@uncounted
def _form(beam: int, receiver: Receiver, fields: Fields) -> None:
    """Write the grey levels of one beam, (bins,)."""
    white, rounding = f32x16(255.0), f32x16(0.5)
    for q in range(0, fields.real.shape[1], WIDTH):
        real = imaginary = f32x16(0.0)
        for k in range(receiver.pattern.shape[0]):
            weight = f32x16(receiver.pattern[k])
            real = real + weight * load(fields.real, beam + k, q)
            imaginary = imaginary + weight * load(fields.imaginary, beam + k, q)
        amplitude = sqrt(real * real + imaginary * imaginary) * load(receiver.gain, 0, q)
        store_i32(fields.levels, q, to_i32(minimum(amplitude, white) + rounding))
