"""The registry is light, and says the same as the packages it names."""

import subprocess
import sys

import pytest

from sim import registry
from sim.trackers import TRACKERS
from sim.trackers.template import CRITERIA, METHODS
from sim.trackers.warps import WARPS


def test_the_registry_offers_the_trackers_that_there_are() -> None:
    assert set(registry.TRACKERS) | {registry.TRUTH} == set(TRACKERS)


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [(registry.WARPS, WARPS), (registry.CRITERIA, CRITERIA), (registry.METHODS, METHODS)],
)
def test_the_registry_offers_the_options_that_the_trackers_have(
    ours: dict[str, str], theirs: dict[str, str]
) -> None:
    assert set(ours) == set(theirs)


def test_every_entry_loads() -> None:
    registry.load_all()


def test_forms_need_neither_numba_nor_opencv() -> None:
    code = (
        "import sys; from sim.registry import benchmark; benchmark('currents-v1').schema();"
        "print([name for name in ('numba', 'cv2', 'pybullet', 'scipy') if name in sys.modules])"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "[]"


def test_an_unknown_benchmark_is_a_key_error() -> None:
    with pytest.raises(KeyError):
        registry.benchmark("currents-v0")
