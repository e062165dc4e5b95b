"""What the sandbox of a server has can be installed here: the extra `box`, and its example."""

import importlib.util
import io
import json
import os
import runpy
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import onnx
import pytest
from click.testing import CliRunner
from onnx import TensorProto, helper, numpy_helper

from seamark.cli.main import cli
from seamark.sandbox.languages.python.host import OPTIONAL
from tests.services.prepared import SEAMARK, run

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "torch_to_onnx.py"
ABSENT = f"import sys; sys.modules['onnxruntime'] = None\n{SEAMARK}"
PROGRAM = """
import onnxruntime

class Controller:
    def __init__(self, config):
        pass

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
"""
SHORT = ("--set", "levels=0", "--set", "level_duration_s=2", "--set", "settle_s=1", "--seed", "7")


def _network() -> tuple[bytes, np.ndarray, np.ndarray]:
    """Return the network of the example with random weights, and its two matrices."""
    random = np.random.default_rng(5)
    first = random.standard_normal((3, 32)).astype(np.float32)
    second = random.standard_normal((32, 3)).astype(np.float32)
    nodes = [
        helper.make_node("MatMul", ["error", "first"], ["before"]),
        helper.make_node("Tanh", ["before"], ["hidden"]),
        helper.make_node("MatMul", ["hidden", "second"], ["command"]),
    ]
    shape = helper.make_tensor_value_info
    graph = helper.make_graph(
        nodes,
        "policy",
        [shape("error", TensorProto.FLOAT, [1, 3])],
        [shape("command", TensorProto.FLOAT, [1, 3])],
        [numpy_helper.from_array(first, "first"), numpy_helper.from_array(second, "second")],
    )
    opsets = [helper.make_opsetid("", 17)]
    made = helper.make_model(graph, opset_imports=opsets, ir_version=9)
    onnx.checker.check_model(made)
    return bytes(made.SerializeToString()), first, second


def test_the_extra_has_what_boxes_have_beside_the_packages_of_the_simulator() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    extra = {line.partition(">")[0] for line in project["project"]["optional-dependencies"]["box"]}

    assert extra == {*OPTIONAL, "scipy"}
    assert project["dependency-groups"]["box"] == ["seamark[box]"]


@pytest.mark.slow
def test_a_program_that_needs_the_extra_is_told_how_to_install_it(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(PROGRAM)

    # A process that looked for packages before would not look again.
    done = run(ABSENT, "check", "mine.py", on="warm", folder=tmp_path)

    assert done.returncode == 1, done.stderr
    assert "No module named 'onnxruntime'" in done.stdout
    assert 'Here the extra `box` installs it: pip install "seamark[box]' in done.stderr


def test_the_controller_of_the_example_gives_what_its_network_computes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example, (network, first, second) = runpy.run_path(str(EXAMPLE)), _network()
    example["pack"](network, tmp_path / "packed.zip")
    zipfile.ZipFile(tmp_path / "packed.zip").extractall(tmp_path)
    monkeypatch.chdir(tmp_path)

    controller = runpy.run_path("main.py")["Controller"]({})

    for error in np.random.default_rng(6).standard_normal((5, 3)):
        expected = np.tanh(error.astype(np.float32) @ first) @ second
        command = controller.step(SimpleNamespace(error=error))
        np.testing.assert_allclose(command, [*expected, 0.0], rtol=1e-4, atol=1e-5)


@pytest.mark.slow
def test_the_archive_of_the_example_runs_in_the_sandbox(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLE))["pack"](_network()[0], tmp_path / "packed.zip")

    done = CliRunner().invoke(
        cli, ["run", "currents-v1", "--controller", "packed.zip", *SHORT, "--json"]
    )

    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["verdict"] == "ok"


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="PyTorch is not installed")
def test_the_example_exports_the_network_that_it_has_trained(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLE), "--steps", "300", "--out", "packed.zip"]
    subprocess.run(command, cwd=tmp_path, env=dict(os.environ), check=True)
    import onnxruntime

    packed = zipfile.ZipFile(io.BytesIO((tmp_path / "packed.zip").read_bytes()))
    session = onnxruntime.InferenceSession(packed.read("policy.onnx"))

    (command_of_one_metre,) = session.run(None, {"error": np.ones((1, 3), np.float32)})[0]
    np.testing.assert_allclose(command_of_one_metre, 0.5, atol=0.15)
