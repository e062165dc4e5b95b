"""Normal samples have the bits of NumPy's, wherever they come from under the curve."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics.normals import normals

LONG = 1 << 18  # samples, of which some hundred are in the tail, or at the edge of a layer


def assert_same_bits(seed: int, count: int) -> None:
    generator = np.random.Generator(np.random.PCG64(seed))
    own = np.empty(count, np.float32)

    normals(seed, own)

    expected = generator.standard_normal(count, dtype=np.float32)
    np.testing.assert_array_equal(own.view(np.uint32), expected.view(np.uint32))


@given(seed=st.integers(0, 2**64 - 1), count=st.integers(0, 300))
def test_samples_have_the_bits_of_those_of_numpy(seed: int, count: int) -> None:
    assert_same_bits(seed, count)


@pytest.mark.parametrize("seed", range(8))
def test_rare_samples_have_them_as_well(seed: int) -> None:
    assert_same_bits(seed, LONG)
