"""Train a network to recover the box of recover-v1 by imitating the scripted expert, with NumPy.

    seamark demonstrations recover-v1 --format parquet --episodes 160 --out shown
    python examples/imitation/train.py shown --out imitation.zip
    seamark run recover-v1 --controller imitation.zip

Behaviour cloning, from demonstrations alone. What the expert has in mind is a further target: the
phase of its work, and how fast the height that it asks of the tool falls. It sees each
demonstration again to tell them. At the next step, the network gets the phase and the height that
it has come to, which are its memory.

The same demonstrations and the same seed give the same weights where NumPy multiplies matrices in
the same order, which depends on the processor.
"""

import argparse
import json
import os
import sys
import time
import zipfile
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for matrices so small, more cost time

import numpy as np

from seamark.sim.control.manipulation.imitation.features import PHASES, Features
from seamark.sim.control.manipulation.imitation.layers import Layer, save

PACKAGE = "seamark.sim.control.manipulation"
SHARED = ("arm_data", "imitation.features", "kinematics", "sight")
LIBM = '''"""What the modules beside it import of the simulator's arithmetic."""

from math import atan2, cos, sin  # noqa: F401


def sincos(angle):
    """Return sine and cosine."""
    return sin(angle), cos(angle)
'''
HIDDEN = (64, 64)
BATCH, RATE = 1024, 3e-3
CHANGE_WEIGHT = 3.0  # of the steps at which the phase changes
PHASE_LOSS = 0.3


class Samples(NamedTuple):
    """What one episode teaches: features, what the expert commands, and what it has in mind."""

    features: np.ndarray  # (n, features)
    actions: np.ndarray  # (n, m)
    falls: np.ndarray  # (n, 1) [m/s]
    before: np.ndarray  # (n,) phase before the step
    phases: np.ndarray  # (n,) and after it


class Network:
    """Layers of rectified linear units; the first one normalises, the last one scales."""

    def __init__(self, sizes: list[int], random: np.random.Generator) -> None:
        self.weights = [
            random.normal(0.0, np.sqrt(2.0 / inputs), (inputs, outputs)).astype(np.float32)
            for inputs, outputs in pairwise(sizes)
        ]
        self.biases = [np.zeros(size, np.float32) for size in sizes[1:]]

    def layers(self, x: np.ndarray) -> list[np.ndarray]:
        """Return the input and the output of each layer, (n, size) each."""
        values = [x]
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            x = x @ weight + bias
            if number < len(self.weights) - 1:
                x = np.maximum(x, 0.0)
            values.append(x)
        return values

    def gradients(self, values: list[np.ndarray], error: np.ndarray) -> list[np.ndarray]:
        """Return those of all weights, then of all biases, for an error of the output."""
        of_weights, of_biases = [], []
        for number in reversed(range(len(self.weights))):
            of_weights.insert(0, values[number].T @ error)
            of_biases.insert(0, error.sum(axis=0))
            error = (error @ self.weights[number].T) * (values[number] > 0.0)
        return [*of_weights, *of_biases]


def in_units(network: Network, mean: Any, spread: Any, scale: Any) -> list[Layer]:
    """Return the layers of a network with the scales of its inputs and outputs, in float32."""
    weights, biases = [*network.weights], [*network.biases]
    weights[0] = weights[0] / spread[:, None]
    biases[0] = biases[0] - mean @ weights[0]
    scale = np.concatenate([scale, np.ones(PHASES)])
    weights[-1], biases[-1] = weights[-1] * scale, biases[-1] * scale
    return [
        (weight.astype(np.float32), bias.astype(np.float32))
        for weight, bias in zip(weights, biases, strict=True)
    ]


class Teacher:
    """The built-in expert, and the features of what it sees."""

    def __init__(self, task: Any, attempt: Any, first: Any) -> None:
        from seamark.demonstrations.episodes import Expert  # noqa: PLC0415

        config = config_of(task)
        self.arm = config.arm
        self.expert = Expert(task, attempt, first)
        self.features = Features(config.for_program(), tool_of(config))
        self.rows: list[Any] = []

    def see(self, observation: Any) -> np.ndarray:
        """Learn from an observation, and return what the expert does."""
        from seamark.gym.spaces import named  # noqa: PLC0415

        told = named(observation, arm=self.arm)
        features, before = self.features.update(told), self.features.phase
        action = np.array(self.expert.action(observation))
        phase, fall = self.expert.controller.phase, self.expert.controller.falling
        self.features.advance(phase, fall, told)
        self.rows.append((features, action, [fall], before, phase))
        return action

    def samples(self) -> Samples:
        """Return all that was seen."""
        return Samples(*map(np.array, zip(*self.rows, strict=True)))


def tool_of(config: Any) -> list[float]:
    """Return where the tool is in the body, with the arm in its working posture [m]."""
    from seamark.sim.control.manipulation.approach import WORKING  # noqa: PLC0415
    from seamark.sim.control.manipulation.arm_reading import data_of, mount_of  # noqa: PLC0415
    from seamark.sim.control.manipulation.kinematics import ArmKinematics  # noqa: PLC0415
    from seamark.sim.vehicles import load  # noqa: PLC0415
    from seamark.sim.vehicles.linkage_reading import load_linkage  # noqa: PLC0415

    arm = load_linkage(config.arm)
    kinematics = ArmKinematics(data_of(arm), mount_of(load(config.vehicle), arm.name))
    return list(kinematics.tool([*WORKING[arm.name]]).point)


def shown(folder: Path) -> Iterator[Samples]:
    """Yield what each demonstration teaches; the expert sees it again to tell its phases."""
    import pyarrow.dataset as arrow  # noqa: PLC0415

    from seamark.demonstrations.episodes import Attempt  # noqa: PLC0415

    about = json.loads((folder / "seamark.json").read_text())
    steps = arrow.dataset(folder / "steps", format="parquet")
    episodes = arrow.dataset(folder / "episodes.parquet").to_table().to_pylist()
    for episode in episodes:
        chosen = arrow.field("episode") == episode["episode"]
        table = steps.to_table(columns=["observation", "action"], filter=chosen)
        observations = np.array(table["observation"].to_pylist())
        actions = np.array(table["action"].to_pylist()[:-1])
        attempt = Attempt(number=0, seed=episode["seed"], level=episode["level"])
        teacher = Teacher(task_of(about), attempt, observations[0])
        for observation, done in zip(observations, actions, strict=False):
            if not np.array_equal(teacher.see(observation), done):
                sys.exit("This version's expert does not act as in the demonstrations.")
        yield teacher.samples()


def known(folder: Path, cpu_s: int | None) -> dict[str, Any]:
    """Return what is kept of demonstrations, and where the tool is in the body [m]."""
    from pyarrow import parquet  # noqa: PLC0415

    about = json.loads((folder / "seamark.json").read_text())
    episodes = parquet.read_table(folder / "episodes.parquet").to_pydict()
    return {
        "demonstrations": {
            "benchmark": about["benchmark"],
            "expert": about["expert"],
            "settings": about["options"]["settings"],
            "seeds": [min(episodes["seed"]), max(episodes["seed"])],
            "episodes": len(episodes["seed"]),
            "successful": sum(episodes["success"]),
            "steps": sum(episodes["steps"]),
            "cpu_s": cpu_s,
        },
        "tool_m": tool_of(config_of(task_of(about))),
    }


def task_of(about: dict[str, Any]) -> Any:
    """Return the task of demonstrations."""
    from seamark.demonstrations.episodes import Task  # noqa: PLC0415

    options = {name: about["options"][name] for name in ("settings", "reward", "dtype")}
    return Task(benchmark=about["benchmark"], expert=about["expert"], **options)


def config_of(task: Any) -> Any:
    """Return the configuration of a task."""
    from seamark.sim import registry  # noqa: PLC0415

    return registry.benchmark(task.benchmark).read(task.settings)


def trained(samples: list[Samples], steps: int, random: np.random.Generator) -> list[Layer]:
    """Return the layers of a network that has learned all samples, by Adam (Kingma and Ba 2015)."""
    x, actions, falls, before, phases = map(np.concatenate, zip(*samples, strict=True))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-3
    x = ((x - mean) / spread).astype(np.float32)
    told = np.hstack([actions, falls])
    scale = told.std(axis=0) + 1e-3
    targets = (told / scale).astype(np.float32)
    weight = np.where(before != phases, CHANGE_WEIGHT, 1.0).astype(np.float32)
    network = Network([x.shape[1], *HIDDEN, targets.shape[1] + PHASES], random)
    parameters = [*network.weights, *network.biases]
    first, second = ([np.zeros_like(one) for one in parameters] for _ in range(2))
    for step in range(1, steps + 1):
        rate = RATE * 0.5 * (1.0 + float(np.cos(np.pi * step / steps)))
        chosen = random.integers(len(x), size=BATCH)
        values = network.layers(x[chosen])
        error = output_error(values[-1], targets[chosen], phases[chosen], weight[chosen])
        for i, gradient in enumerate(network.gradients(values, error)):
            first[i] += 0.1 * (gradient - first[i])
            second[i] += 0.001 * (gradient * gradient - second[i])
            size = np.sqrt(second[i] / (1.0 - 0.999**step)) + 1e-8
            parameters[i] -= rate * first[i] / (1.0 - 0.9**step) / size
    whole = network.layers(x[:: max(len(x) // 20_000, 1)])[-1]
    some = slice(None, None, max(len(x) // 20_000, 1))
    wrong = (whole[:, -PHASES:].argmax(axis=1) != phases[some]).mean()
    square = ((whole[:, :-PHASES] - targets[some]) ** 2).mean()
    print(f"  {len(x)} steps: error {square:.3f} of the variance, phase wrong {100 * wrong:.2f} %")
    return in_units(network, mean, spread, scale)


def output_error(
    output: np.ndarray, targets: np.ndarray, phases: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """Return the gradient of the loss: squares of the command, cross entropy of the phase."""
    count = len(output)
    error = np.empty_like(output)
    error[:, :-PHASES] = 2.0 * (output[:, :-PHASES] - targets) / count
    scores = output[:, -PHASES:]
    shares = np.exp(scores - scores.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    shares[np.arange(count), phases] -= 1.0
    error[:, -PHASES:] = PHASE_LOSS * shares * weight[:, None] / count
    return error


def exported(layers: list[Layer]) -> bytes:
    """Return the network in ONNX's format."""
    from onnx import TensorProto, helper, numpy_helper  # noqa: PLC0415

    nodes, stored, value = [], [], "features"
    for number, (weights, biases) in enumerate(layers):
        names = [value, f"weights{number}", f"biases{number}"]
        stored += [
            numpy_helper.from_array(np.asarray(array, np.float32), name)
            for array, name in zip((weights, biases), names[1:], strict=True)
        ]
        value = f"layer{number}"
        nodes.append(helper.make_node("Gemm", names, [value]))
        if number < len(layers) - 1:
            nodes.append(helper.make_node("Relu", [value], [f"rectified{number}"]))
            value = f"rectified{number}"
    outputs = {"command": layers[-1][1].size - 1 - PHASES, "fall": 1, "phase": PHASES}
    stored.append(numpy_helper.from_array(np.array([*outputs.values()]), "sizes"))
    nodes.append(helper.make_node("Split", [value, "sizes"], [*outputs], axis=1))

    def described(name: str, size: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, size])

    graph = helper.make_graph(
        nodes,
        "policy",
        [described("features", len(layers[0][0]))],
        [described(name, size) for name, size in outputs.items()],
        stored,
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    return made.SerializeToString()


def shared() -> Iterator[tuple[str, str]]:
    """Yield name and text of the simulator's modules that the program has, too."""
    for module in SHARED:
        [folder] = find_spec(PACKAGE).submodule_search_locations
        text = Path(folder, *module.split(".")).with_suffix(".py").read_text("utf-8")
        for package in (PACKAGE, "seamark.sim.numerics"):
            text = text.replace(f"from {package}.", "from ")
        yield f"{module.rpartition('.')[-1]}.py", text
    yield "libm.py", LIBM


def pack(layers: list[Layer], policy: dict[str, Any], out: Path) -> None:
    """Write the archive that is submitted; `policy` is what is known beside the network."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(Path(__file__).with_name("main.py"), "main.py")
        for name, text in shared():
            archive.writestr(name, text)
        archive.writestr("policy.json", json.dumps(policy))
        archive.writestr("policy.onnx", exported(layers))


def main() -> None:
    """Train and pack."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("shown", type=Path, help="Demonstrations as Parquet.")
    parser.add_argument("--steps", type=int, default=12000, help="Of the optimiser.")
    parser.add_argument("--seed", type=int, default=1, help="Of the training.")
    parser.add_argument("--out", type=Path, default=Path("imitation.zip"))
    parser.add_argument(
        "--keep", type=Path, metavar="FOLDER", help="Write policy.json and weights.npz there, too."
    )
    parser.add_argument(
        "--shown-cpu-s", type=int, metavar="SECONDS", help="Cost of the demonstrations, to keep."
    )
    chosen = parser.parse_args()
    began = time.process_time()
    samples = [*shown(chosen.shown)]
    layers = trained(samples, chosen.steps, np.random.default_rng(chosen.seed))
    cost_s = time.process_time() - began
    policy = known(chosen.shown, chosen.shown_cpu_s) | {
        "trained": datetime.now(UTC).date().isoformat(),
        "training": {"seed": chosen.seed, "steps": chosen.steps, "cpu_s": round(cost_s)},
        "most": np.max([np.abs(each.actions).max(axis=0) for each in samples], axis=0).tolist(),
    }
    pack(layers, policy, chosen.out)
    if chosen.keep:
        (chosen.keep / "policy.json").write_text(json.dumps(policy, indent=1) + "\n", "utf-8")
        save(layers, chosen.keep / "weights.npz")
    print(f"Wrote {chosen.out} after {cost_s:.0f} s of processor time.")


if __name__ == "__main__":
    main()
