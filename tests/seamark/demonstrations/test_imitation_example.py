"""The example that learns from demonstrations, and the learned entry that it made."""

import json
import runpy
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from onnx import numpy_helper

from seamark.cli.main import cli
from seamark.programs import preparation
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sim import registry
from seamark.sim.control.manipulation.imitation import POLICY
from seamark.sim.control.manipulation.imitation.controller import WEIGHTS
from seamark.sim.control.manipulation.imitation.features import PHASES
from seamark.sim.control.manipulation.imitation.layers import forward, load
from seamark.sim.engine.program import Command
from seamark.sim.engine.trial import run_trial
from seamark.worker.evaluation.program_adapters import ControllerAdapter
from tests.services.prepared import printed

EXAMPLE = Path(__file__).parents[3] / "examples" / "imitation"
TRAIN = f"import runpy; runpy.run_path({str(EXAMPLE / 'train.py')!r}, run_name='__main__')"
SHORT = ("--set", "levels=0.1", "--set", "level_duration_s=2")
WEIGHTS_NAME = WEIGHTS.name


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short demonstrations."""
    folder = tmp_path_factory.mktemp("imitation") / "shown"
    options = ("--format", "parquet", "--episodes", "2", "--jobs", "1", "--out", str(folder))
    ended = CliRunner().invoke(cli, ["demonstrations", "recover-v1", *options, *SHORT])
    assert ended.exit_code == 0, ended.output
    return folder


def train(shown: Path, target: Path) -> Path:
    """Return the folder that a short training writes its archive and its policy to."""
    target.mkdir()
    short = ("--steps", "20", "--out", str(target / "imitation.zip"))
    printed(TRAIN, str(shown), *short, "--keep", str(target), "--shown-cpu-s", "7")
    return target


@pytest.fixture(scope="module")
def learned(shown: Path) -> Path:
    return train(shown, shown.parent / "learned")


def arrays_of(network: bytes) -> dict[str, NDArray[Any]]:
    """Return name -> array of what a network in ONNX's format has stored."""
    stored = onnx.load_from_string(network).graph.initializer
    return {each.name: numpy_helper.to_array(each) for each in stored}


@pytest.mark.slow
def test_the_kept_weights_are_those_of_the_network_in_the_archive(learned: Path) -> None:
    with zipfile.ZipFile(learned / "imitation.zip") as archive:
        stored = arrays_of(archive.read("policy.onnx"))
        policy = json.loads(archive.read("policy.json"))

    assert policy == json.loads((learned / "policy.json").read_text())
    with np.load(learned / WEIGHTS_NAME) as kept:
        assert {*stored} == {*kept.files, "sizes"}
        for name in kept.files:
            assert kept[name].dtype == stored[name].dtype == np.float32
            np.testing.assert_array_equal(kept[name], stored[name])


@pytest.mark.slow
def test_what_is_kept_of_a_training_says_what_it_learned_from(learned: Path) -> None:
    policy = json.loads((learned / "policy.json").read_text())

    told = policy["demonstrations"]
    assert (told["seeds"], told["episodes"], told["steps"]) == ([1_000_000, 1_000_001], 2, 80)
    assert (told["benchmark"], told["expert"], told["cpu_s"]) == ("recover-v1", "scripted", 7)
    assert told["settings"] == {"levels": [0.1], "level_duration_s": 2.0}
    assert (policy["training"]["seed"], policy["training"]["steps"]) == (1, 20)
    assert {*policy} == {*POLICY}


@pytest.mark.slow
def test_the_same_demonstrations_and_seed_give_the_same_weights(shown: Path, learned: Path) -> None:
    again = train(shown, shown.parent / "again")

    assert (again / WEIGHTS_NAME).read_bytes() == (learned / WEIGHTS_NAME).read_bytes()


@pytest.mark.slow
def test_the_archive_runs_in_its_box(learned: Path) -> None:
    options = ("--controller", str(learned / "imitation.zip"), "--seed", "5", *SHORT, "--json")

    ended = CliRunner().invoke(cli, ["run", "recover-v1", *options])

    assert ended.exit_code == 0, ended.output
    assert json.loads(ended.stdout)["metrics"]["levels"][0]["speed"] == 0.1


class Both:
    """The program in the box sees what the built-in entry sees, which acts: to fixed bits."""

    def __init__(self, box: ControllerAdapter, entry: Any) -> None:
        self._box, self._entry = box, entry
        self.commands: list[tuple[Command, Command]] = []
        self.phases: set[int] = set()

    def reset(self, level: dict[str, Any]) -> None:
        self._box.reset(level)
        self._entry.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        self.commands.append((self._box.step(values), self._entry.step(values)))
        self.phases.add(self._entry.controller.features.phase)
        return self.commands[-1][1]


@pytest.mark.slow
@pytest.mark.host
def test_the_entry_acts_as_its_archive_does_in_a_box(
    isolation: IsolationLevel, tmp_path: Path
) -> None:
    archive = tmp_path / "imitation.zip"
    runpy.run_path(str(EXAMPLE / "train.py"))["pack"](load(WEIGHTS), dict(POLICY), archive)
    program = preparation.prepare(archive.read_bytes(), archive.name, role="controller")
    definition = registry.benchmark("recover-v1")
    config: Any = definition.read({"levels": [0.0], "level_duration_s": 60.0})
    experiment = definition.load()
    with Box(limits=Limits(), isolation=isolation) as box:
        given = config.for_program()
        box.load(program.content, program.name, given, experiment.layout(config))
        both = Both(ControllerAdapter(box), experiment.built_in("imitation", config))

        run_trial(definition.name, config, both, seed=4343, trial=1, on_rows=lambda _rows: None)

    boxed, built_in = (np.array(each) for each in zip(*both.commands, strict=True))
    np.testing.assert_allclose(boxed, built_in, rtol=0.0, atol=1e-4)  # [m/s, rad/s]
    assert both.phases == {*range(PHASES)}


def test_the_exported_network_computes_what_the_trained_one_does() -> None:
    train = runpy.run_path(str(EXAMPLE / "train.py"))
    random = np.random.default_rng(1)
    network = train["Network"]([33, 64, 64, 10 + PHASES], random)
    mean, spread = random.normal(size=33), random.uniform(0.1, 2.0, 33)
    layers = train["in_units"](network, mean, spread, random.uniform(0.01, 1.0, 10))
    exported = onnxruntime.InferenceSession(train["exported"](layers))

    for features in random.normal(size=(50, 33)):
        given = np.array([features], np.float32)
        parts = exported.run(None, {"features": given})
        assert [part.shape for part in parts] == [(1, 9), (1, 1), (1, PHASES)]
        computed = forward(layers, features.tolist())
        np.testing.assert_allclose(np.hstack(parts)[0], computed, rtol=1e-4, atol=1e-4)
    assert len(train["exported"](layers)) < 200_000


def test_a_policy_takes_and_gives_the_units_of_what_was_shown() -> None:
    train = runpy.run_path(str(EXAMPLE / "train.py"))
    random = np.random.default_rng(1)
    network = train["Network"]([4, 64, 64, 2 + PHASES], random)
    x = random.normal(3.0, 2.0, (100, 4))
    mean, spread, scale = x.mean(axis=0), x.std(axis=0), np.array([0.1, 5.0])
    output = network.layers(((x - mean) / spread).astype(np.float32))[-1]

    layers = train["in_units"](network, mean, spread, scale)

    for features, learned in zip(x, output, strict=True):
        computed = forward(layers, features.tolist())
        np.testing.assert_allclose(computed[:2], learned[:2] * scale, rtol=1e-3, atol=1e-4)
        np.testing.assert_allclose(computed[2:], learned[2:], rtol=1e-3, atol=1e-4)
