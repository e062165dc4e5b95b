"""The examples of docs/training.md: what they need, and that they write what they have trained."""

import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from seamark.gym.spaces import named
from tests.services.prepared import printed

EXAMPLES = Path(__file__).parents[3] / "examples"
TRAIN = (
    f"import runpy; runpy.run_path({str(EXAMPLES / 'train_station_keeping.py')!r}, "
    "run_name='__main__')"
)


@pytest.mark.parametrize(
    ("example", "library", "install"),
    [
        ("ppo", "stable_baselines3", 'pip install "stable-baselines3>=2.9"'),
        ("eye", "torch", "pip install torch onnx"),
        ("detector", "torch", "pip install torch"),
    ],
)
def test_an_example_without_its_library_says_what_to_install(
    example: str, library: str, install: str
) -> None:
    folder = EXAMPLES / example
    hidden = f"import sys, runpy; sys.modules[{library!r}] = None; "
    program = (
        f"{hidden}sys.path.insert(0, {str(folder)!r}); "
        f"runpy.run_path({str(folder / 'train.py')!r}, run_name='__main__')"
    )

    command = [sys.executable, "-c", program]
    ended = subprocess.run(command, check=False, capture_output=True, text=True)

    assert ended.returncode == 1
    assert install in ended.stderr
    assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_a_short_training_writes_a_controller_that_acts_like_its_policy(tmp_path: Path) -> None:
    out = tmp_path / "trained.py"
    options = ["--seconds", "0", "--candidates", "4", "--level-s", "2", "--out", str(out)]

    printed(TRAIN, *options, on="warm")

    written = runpy.run_path(str(out))
    controller = written["Controller"]({})
    gains = np.array([list(written["GAINS"].values())])
    policy = runpy.run_path(str(EXAMPLES / "train_station_keeping.py"))["Policy"](gains, dt=0.05)
    random = np.random.default_rng(1)
    for _ in range(5):
        observation = random.standard_normal(26)
        observation[1] = 0.05
        command = controller.step(named(observation))
        np.testing.assert_allclose(command, policy.act(observation[None])[0])
    assert gains[0] != pytest.approx([0.5, 0.02, 0.0, 0.0, 0.0])
