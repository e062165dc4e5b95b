"""The example of docs/training.md trains, and what it writes is the policy that it trained."""

import runpy
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
