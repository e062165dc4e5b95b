"""Values of the parameters of a program."""

from typing import Any

import pytest

from seamark.programs import parameters
from seamark.programs.parameters import Parameter
from seamark.sim import registry
from seamark.sim.settings.refusal import ConfigurationInvalid

GAIN = Parameter(name="gain", default=0.5, low=0, high=2)
ORDER = Parameter(name="order", default=3, low=1)
SWITCH = Parameter(name="switch", default=True)
ALL = (GAIN, ORDER, SWITCH)


def test_what_is_not_given_has_its_default() -> None:
    assert parameters.read(ALL, {"gain": 1}) == {"gain": 1.0, "order": 3, "switch": True}


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [("gain", "1.5", 1.5), ("order", "4", 4), ("order", "4.0", 4), ("switch", "no", False)],
)
def test_texts_of_forms_and_command_lines_are_converted(name: str, text: str, value: Any) -> None:
    found = parameters.read(ALL, {name: text})[name]

    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("gain", 3, "gain must be a number from 0 to 2, not 3.0."),
        ("gain", "fast", "gain must be a number from 0 to 2, not 'fast'."),
        ("gain", True, "gain must be a number from 0 to 2, not 'True'."),
        ("gain", float("nan"), "gain must be a number from 0 to 2, not nan."),
        ("order", 1.5, "order must be a whole number from 1, not '1.5'."),
        ("order", 10**400, "order must be a whole number from 1, not "),
        ("switch", 2, "switch must be true or false."),
        ("speed", 1, "The program has no parameter speed; it declares gain, order, switch."),
    ],
)
def test_a_value_that_is_not_allowed_is_refused_by_name(
    name: str, value: object, sentence: str
) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        parameters.read(ALL, {name: value})

    assert refused.value.errors[f"parameters.{name}"].startswith(sentence)


def test_parameters_may_be_named_beside_the_settings() -> None:
    found = parameters.gathered({"gain": 1.0, "kp": 0.4}, ALL)

    assert found == {"kp": 0.4, "parameters": {"gain": 1.0}}


def test_a_setting_with_the_name_of_a_parameter_stays_in_a_stored_configuration() -> None:
    stored = {"gain": 0.1, "parameters": {"gain": 1.0, "order": 3, "switch": True}}

    assert parameters.gathered(stored, ALL) == stored


def test_no_setting_of_a_benchmark_is_called_like_the_key_of_the_parameters() -> None:
    for name in registry.BENCHMARKS:
        assert parameters.KEY not in registry.benchmark(name).configuration.model_fields
