"""The dictionary of what environments draw, and its tables in docs/training.md."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from seamark.gym import BENCHMARKS, randomisation
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.trial_spreads import TrialSpreadSettings

GUIDE = Path(__file__).parents[3] / "docs" / "training.md"
NAME = "seamark/StationKeeping-v3"
TRUTH: dict[str, object] = {"tracker": "truth", "levels": [0.3]}


def shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{each:g}" for each in value)
    return f"{value:g}" if type(value) is float else str(value).lower()


def cells(name: str, drawn: Any) -> str:
    """Return the cells of a setting in the tables: value, range, meaning."""
    width = "" if drawn["high"] is None else f"{drawn['low']:g} to {drawn['high']:g}"
    unit = drawn["unit"] and f" [{drawn['unit']}]"
    return f"{shown(drawn['value'])} | {width}{unit} | {drawn['meaning']} |"


def test_the_tables_of_the_guide_have_every_setting_as_it_is() -> None:
    usual = randomisation(NAME)
    expected = [f"| `{name}` | {cells(name, usual[name])}" for name in usual]
    others: dict[str, list[str]] = {}
    for gym_id in BENCHMARKS:
        for name, drawn in randomisation(gym_id).items():
            if name not in usual:
                others.setdefault(f"`{name}` | {cells(name, drawn)}", []).append(
                    gym_id.removeprefix("seamark/")
                )
    expected += [f"| {', '.join(where)} | {rest}" for rest, where in others.items()]
    guide = GUIDE.read_text("utf-8").splitlines()

    assert [line for line in expected if line not in guide] == []


def test_nothing_that_is_drawn_per_trial_is_missing() -> None:
    assert TrialSpreadSettings.__annotations__.keys() <= randomisation(NAME).keys()


def test_what_is_drawn_is_changed_by_settings_of_the_same_name() -> None:
    def moved(**settings: object) -> Any:
        assert randomisation(NAME, settings)["drag_spread"]["value"] == settings["drag_spread"]
        env = gymnasium.make(NAME, settings=TRUTH | settings, disable_env_checker=True)
        env.reset(seed=7)
        for _ in range(10):
            observation = env.step(np.array([0.3, 0.0, 0.0, 0.0]))[0]
        return observation

    assert (moved(drag_spread=0.0) != moved(drag_spread=0.5)).any()


@pytest.mark.parametrize("name", ["start_offset_m", "camera_delay_steps", "thrust_spread"])
def test_a_value_beyond_the_range_is_refused(name: str) -> None:
    high = randomisation(NAME)[name]["high"]

    assert high is not None
    with pytest.raises(ConfigurationInvalid):
        randomisation(NAME, {name: high + 1})


def test_an_environment_that_is_not_there_is_refused() -> None:
    with pytest.raises(gymnasium.error.UnregisteredEnv):
        randomisation("seamark/StationKeeping-v99")
