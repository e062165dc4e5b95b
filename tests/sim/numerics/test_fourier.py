"""The Fourier transform that gives the same bits everywhere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics.fourier import inverse_real, roots, transform


@given(seed=st.integers(0, 10**6), height=st.integers(0, 6), width=st.integers(0, 6))
def test_it_agrees_with_numpy(seed: int, height: int, width: int) -> None:
    random = np.random.default_rng(seed)
    image = random.normal(size=(2**height, 2**width))
    data = image.astype(np.complex128)

    transform(data, roots(2**width), roots(2**height))

    assert data == pytest.approx(np.fft.fft2(image), abs=1e-10)


def test_the_inverse_gives_the_image_again() -> None:
    image = np.random.default_rng(1).normal(size=(16, 32))
    data, again = image.astype(np.complex128), np.empty((16, 32))
    transform(data, roots(32), roots(16))

    inverse_real(data, roots(32), roots(16), again)

    assert again == pytest.approx(image, abs=1e-13)


def test_a_size_that_is_no_power_of_two_is_refused() -> None:
    with pytest.raises(ValueError, match="24 is no power of two"):
        roots(24)
