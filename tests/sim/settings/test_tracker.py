"""The settings of the tracker are composed from the declarations of the registry."""

from pathlib import Path

import pytest

from seamark.sim import registry
from seamark.sim.registry import TRUTH, benchmark
from seamark.sim.settings.declared import declarations, declared_options
from seamark.sim.trackers import declaration, option_errors

DECLARATION = """
from seamark.sim.trackers.declaration import Option, TrackerDeclaration

WARP = Option(name="warp", default="rt", title="Warp", help="Another warp.")
TRACKER = TrackerDeclaration(label="Conflicting", path="none:Tracker", options=(WARP,))
"""


def test_two_trackers_cannot_declare_different_options_of_one_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tmp_path.joinpath("conflicting_tracker.py").write_text(DECLARATION)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(registry.TRACKERS, "conflicting", "conflicting_tracker:TRACKER")

    with pytest.raises(ValueError, match="tracker conflicting: another tracker's warp differs"):
        declared_options("tracker", declarations(registry.TRACKERS, declaration))


@pytest.mark.parametrize("name", registry.TRACKERS)
def test_each_value_at_the_end_of_a_range_is_allowed_and_the_next_is_not(name: str) -> None:
    for option in declaration(name).options:
        if option.low is None or option.high is None:
            continue
        assert not option.error(option.low)
        assert not option.error(option.high)
        assert "must be from" in option.error(option.low - 1e-6)
        assert "must be from" in option.error(option.high + 1e-6)


def test_ground_truth_has_no_options_and_no_errors() -> None:
    config = benchmark("currents-v1").read({"tracker": TRUTH}).model_dump()

    assert config["tracker"] == TRUTH
    assert option_errors(TRUTH, {"warp": "spline"}) == {}


def test_options_of_other_trackers_are_ignored() -> None:
    config = benchmark("currents-v1").read({"tracker": "box", "warp": "srt", "search_px": 30})

    assert config.tracker_options() == {"search_px": 30}  # type: ignore[attr-defined]
