"""What `--param` accepts, and the values that it stands for."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.failures import UsageRefused
from seamark.tuning.search_space import Dimension, Schema, read_dimensions

TUNABLE: dict[str, Schema] = {
    "kp": {"type": "number", "minimum": 0, "maximum": 5},
    "phi": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
    "steps": {"type": "integer", "minimum": 1, "maximum": 9},
    "heave": {"type": "boolean"},
    "method": {"type": "string", "enum": ["esm", "ic"]},
    "own": {"type": "number"},
}


def _read(text: str) -> Dimension:
    (found,) = read_dimensions([text], TUNABLE)
    return found


@given(share=st.floats(0.0, 1.0), low=st.floats(0.0, 3.0), log=st.booleans())
def test_every_share_of_a_range_is_a_value_inside_it(share: float, low: float, log: bool) -> None:
    one = Dimension(name="kp", low=low, high=4.0, logarithmic=log)

    assert low <= float(one.value_at(share)) <= 4.0


@pytest.mark.parametrize("text", ["kp=0.1:2", "kp=0.1:2:log", "kp=0:0.5:log", "kp"])
def test_a_range_reaches_from_end_to_end_and_a_value_has_its_share(text: str) -> None:
    one = _read(text)

    assert (one.value_at(0.0), one.value_at(1.0)) == (one.low, one.high)
    assert one.share_of(float(one.value_at(0.4))) == pytest.approx(0.4, abs=1e-3)


def test_a_logarithmic_range_gives_small_values_as_much_room_as_large_ones() -> None:
    assert _read("kp=0.01:1:log").value_at(0.5) == pytest.approx(0.1)
    assert float(_read("kp=0:1:log").value_at(0.5)) < 0.05


def test_without_a_range_all_that_the_setting_allows_is_searched() -> None:
    assert (_read("kp").low, _read("kp").high) == (0.0, 5.0)
    assert 0.0 < _read("phi").low < 0.01
    assert _read("heave").values == (False, True)
    assert _read("method").values == ("esm", "ic")
    assert _read("steps").grid(99) == tuple(range(1, 10))


def test_a_list_has_the_types_of_its_setting() -> None:
    assert _read("kp=0.5, 1").values == (0.5, 1.0)
    assert _read("steps=2,4").values == (2, 4)
    assert _read("heave=true,false").values == (True, False)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("kx=0:1", "These can: kp, phi"),
        ("kp=2:1", "below the second"),
        ("kp=1:9", "may be from 0 to 5"),
        ("kp=nan:1", "nan is not a number"),
        ("kp=a:1", "a is not a number"),
        ("kp=0:1:sqrt", "write it as kp=0.1:2"),
        ("kp=0:1:log:3", "write it as kp=0.1:2"),
        ("kp=1,1", "different values"),
        ("kp=", "different values"),
        ("own", "declares no range"),
        ("heave=0:1", "not a number: list its values"),
        ("heave=maybe", "neither true nor false"),
        ("own=-1:1:log", "starts at 0 or above"),
    ],
)
def test_a_wrong_range_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(UsageRefused, match=reason):
        _read(text)


def test_the_same_parameter_twice_is_refused() -> None:
    with pytest.raises(UsageRefused, match="kp is listed twice"):
        read_dimensions(["kp=0:1", "kp=1:2"], TUNABLE)
