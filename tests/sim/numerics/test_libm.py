"""Elementary functions: exact enough, and made of plain IEEE arithmetic."""

import math

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics import libm

angles = st.floats(-2000.0, 2000.0)
finite = st.floats(-1e6, 1e6)
DISPATCHERS = ["sincos", "sin", "cos", "exp", "log", "atan2", "asin"]


@given(x=angles)
def test_sine_and_cosine_are_within_one_unit_of_the_library(x: float) -> None:
    assert libm.sin(x) == pytest.approx(math.sin(x), abs=3e-16)
    assert libm.cos(x) == pytest.approx(math.cos(x), abs=3e-16)


@given(x=st.floats(-1e6, 1e6))
def test_large_angles_are_reduced_without_loss(x: float) -> None:
    assert libm.sin(x) == pytest.approx(math.sin(x), abs=1e-15)


@given(x=angles)
def test_squares_of_sine_and_cosine_add_to_one(x: float) -> None:
    s, c = libm.sincos(x)

    assert s * s + c * c == pytest.approx(1.0, abs=5e-16)


@given(x=st.floats(-745.0, 709.7))
def test_exponential_has_the_precision_of_the_library(x: float) -> None:
    assert libm.exp(x) == pytest.approx(math.exp(x), rel=1e-15, abs=1e-323)


def test_exponential_handles_the_ends_of_its_range() -> None:
    assert libm.exp(0.0) == 1.0
    assert libm.exp(710.0) == math.inf
    assert libm.exp(-746.0) == 0.0
    assert math.isnan(libm.exp(math.nan))


@given(x=st.floats(1e-300, 1e300))
def test_logarithm_has_the_precision_of_the_library(x: float) -> None:
    assert libm.log(x) == pytest.approx(math.log(x), rel=1e-15, abs=2e-16)


def test_logarithm_handles_the_ends_of_its_range() -> None:
    assert libm.log(1.0) == 0.0
    assert libm.log(0.0) == -math.inf
    assert libm.log(math.inf) == math.inf
    assert math.isnan(libm.log(-1.0))
    assert math.isnan(libm.log(math.nan))


@given(y=finite, x=finite)
def test_angle_of_a_point_has_the_precision_of_the_library(y: float, x: float) -> None:
    expected = math.atan2(y + 0.0, abs(x) if x == 0.0 else x)

    assert abs(libm.atan2(y, x)) == pytest.approx(abs(expected), rel=1e-15)


def test_angles_of_the_four_quadrants_have_their_signs() -> None:
    corners = [libm.atan2(y, x) / math.pi for y, x in ((1, 1), (1, -1), (-1, -1), (-1, 1))]

    assert corners == [0.25, 0.75, -0.75, -0.25]
    assert libm.atan2(0.0, 0.0) == 0.0


@given(x=st.floats(-1.0, 1.0))
def test_arc_sine_has_the_precision_of_the_library(x: float) -> None:
    assert libm.asin(x) == pytest.approx(math.asin(x), rel=1e-15)


def test_arguments_out_of_range_give_nan() -> None:
    values = [
        libm.sin(1e7),
        libm.cos(math.inf),
        libm.asin(1.1),
        libm.atan2(math.nan, 1.0),
    ]

    assert np.isnan(values).all()


@pytest.mark.parametrize("name", DISPATCHERS)
def test_machine_code_has_no_fused_operations_and_no_library_calls(name: str) -> None:
    function = getattr(libm, name)
    arity = function.py_func.__code__.co_argcount

    compiled = numba.njit(error_model="numpy")(function.py_func)
    compiled(*[0.5] * arity)
    (assembly,) = compiled.inspect_asm().values()

    assert "fmadd" not in assembly
    assert "fmsub" not in assembly
    assert "fnmadd" not in assembly
    for call in ("$sin,", "$cos,", "$exp,", "$log,", "$atan2,", "$asin,"):
        assert call not in assembly
