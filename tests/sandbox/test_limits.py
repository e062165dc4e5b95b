"""Limits that make no sense never reach a box."""

import math
from dataclasses import fields

import pytest

from seamark.sandbox.limits import MEANING, Limits

NAMES = [field.name for field in fields(Limits)]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
def test_a_limit_that_is_not_a_positive_number_is_refused(name, value) -> None:
    with pytest.raises(ValueError, match=name):
        Limits(**{name: value})


def test_a_wall_limit_below_the_cpu_limit_is_refused() -> None:
    with pytest.raises(ValueError, match="shorter"):
        Limits(cpu_s=10.0, wall_s=5.0)


def test_every_limit_has_an_explanation() -> None:
    assert set(MEANING) == set(NAMES)
