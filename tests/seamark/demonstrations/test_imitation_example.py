"""The example that learns from demonstrations: what it writes is the policy that it trained."""

import json
import os
import runpy
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.gym.spaces import named
from seamark.sim import registry
from tests.seamark.demonstrations.replay import replayed

EXAMPLE = Path(__file__).parents[3] / "examples" / "imitation"
SHORT = ("--set", "levels=0.1", "--set", "level_duration_s=2")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a short training writes, beside the demonstrations that it learned from."""
    folder = tmp_path_factory.mktemp("imitation")
    shown, out = folder / "shown", folder / "imitation.zip"
    options = ("--format", "parquet", "--episodes", "2", "--jobs", "1", "--out", str(shown))
    ended = CliRunner().invoke(cli, ["demonstrations", "recover-v1", *options, *SHORT])
    assert ended.exit_code == 0, ended.output
    short = ("--steps", "20", "--out", str(out))
    subprocess.run(
        [sys.executable, str(EXAMPLE / "train.py"), str(shown), *short],
        check=True,
        env=os.environ | {"PYTHONPATH": str(EXAMPLE.parents[1])},
    )
    return out


@pytest.mark.slow
def test_the_archive_commands_what_the_policy_does_on_the_features_of_each_observation(
    archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    zipfile.ZipFile(archive).extractall(tmp_path)
    monkeypatch.chdir(tmp_path)
    program = runpy.run_path(str(tmp_path / "main.py"))
    config: Any = registry.benchmark("recover-v1").read({"levels": [0.1]})
    controller = program["Controller"](config.for_program())
    network = onnxruntime.InferenceSession(str(tmp_path / "policy.onnx"))
    known = json.loads((tmp_path / "policy.json").read_text())
    features = program["Features"](config.for_program(), known["tool_m"])
    seen = set()

    for step in replayed(archive.parent / "shown", 1_000_000, 0, np.zeros((30, 9))):
        observation = named(step.observation, arm=config.arm)
        given = np.array([features.update(observation)], np.float32)
        command, phase = network.run(None, {"features": given})
        features.advance(int(phase[0].argmax()), observation.depth)
        commanded = controller.step(observation)
        most = np.array(known["most"])
        np.testing.assert_array_equal(commanded, np.clip(command[0].astype(float), -most, most))
        seen.add(tuple(commanded))

    assert len(seen) > 5


@pytest.mark.slow
def test_the_archive_runs_in_its_box(archive: Path) -> None:
    options = ("--controller", str(archive), "--seed", "5", *SHORT, "--json")

    ended = CliRunner().invoke(cli, ["run", "recover-v1", *options])

    assert ended.exit_code == 0, ended.output
    assert json.loads(ended.stdout)["metrics"]["levels"][0]["speed"] == 0.1


def test_the_exported_network_computes_what_the_trained_one_does() -> None:
    train = runpy.run_path(str(EXAMPLE / "train.py"))
    random = np.random.default_rng(1)
    network = train["Network"]([36, 64, 64, 9 + 5], random)
    mean, spread = random.normal(size=36), random.uniform(0.1, 2.0, 36)
    policy = train["Policy"](network, mean, spread, random.uniform(0.01, 1.0, 9))
    exported = onnxruntime.InferenceSession(train["exported"](policy))

    for features in random.normal(size=(50, 36)):
        command, phase = policy.act(features)
        given = np.array([features], np.float32)
        in_onnx, scores = exported.run(None, {"features": given})
        np.testing.assert_allclose(in_onnx[0], command, rtol=1e-4, atol=1e-5)
        assert int(scores[0].argmax()) == phase
    assert len(train["exported"](policy)) < 200_000


def test_a_policy_takes_and_gives_the_units_of_what_was_shown() -> None:
    train = runpy.run_path(str(EXAMPLE / "train.py"))
    random = np.random.default_rng(1)
    network = train["Network"]([4, 64, 64, 2 + 5], random)
    x = random.normal(3.0, 2.0, (100, 4))
    mean, spread, scale = x.mean(axis=0), x.std(axis=0), np.array([0.1, 5.0])
    output = network.layers(((x - mean) / spread).astype(np.float32))[-1]

    policy = train["Policy"](network, mean, spread, scale)

    for features, learned in zip(x, output, strict=True):
        command, phase = policy.act(features)
        np.testing.assert_allclose(command, learned[:2] * scale, rtol=1e-3, atol=1e-4)
        assert phase == learned[2:].argmax()
