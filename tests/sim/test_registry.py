"""The registry is light, and says the same as the packages it names."""

import subprocess
import sys

import pytest

from seamark.sim import registry


@pytest.mark.parametrize("name", registry.TRACKERS)
def test_every_option_of_a_tracker_is_a_setting(name: str) -> None:
    settings = registry.benchmark("currents-v1").configuration.model_fields

    assert set(registry.TRACKERS[name].options) <= set(settings)


def test_every_entry_loads() -> None:
    registry.load_all()


def test_forms_need_neither_numba_nor_opencv() -> None:
    code = (
        "import sys; from seamark.sim.registry import benchmark; benchmark('currents-v1').schema();"
        "print([name for name in ('numba', 'cv2', 'pybullet', 'scipy') if name in sys.modules])"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == "[]"


def test_an_unknown_benchmark_is_a_key_error() -> None:
    with pytest.raises(KeyError):
        registry.benchmark("currents-v0")
