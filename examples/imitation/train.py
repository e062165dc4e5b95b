"""Train a network to recover the box of recover-v1 by imitating the scripted expert, with NumPy.

    seamark demonstrations recover-v1 --format parquet --episodes 64 --out shown
    python examples/imitation/train.py shown --out imitation.zip
    seamark run recover-v1 --controller imitation.zip

Behaviour cloning, from demonstrations alone. The phase of the expert's work is a second target:
the expert sees each demonstration again to tell it. At the next step, the network gets the phase
that it has come to, which is its memory.
"""

import argparse
import json
import os
import sys
import time
import zipfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for matrices so small, more cost time

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from main import PHASES, Features  # noqa: E402

HIDDEN = (64, 64)
BATCH, RATE = 1024, 3e-3
CHANGE_WEIGHT = 20.0  # of the steps at which the phase changes
PHASE_LOSS = 0.3


class Samples(NamedTuple):
    """What one episode teaches: features, what the expert commands, and its phases."""

    features: np.ndarray  # (n, features)
    actions: np.ndarray  # (n, m)
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


class Policy:
    """A network with the scales of its inputs and outputs."""

    def __init__(self, network: Network, mean: Any, spread: Any, scale: Any) -> None:
        weights, biases = [*network.weights], [*network.biases]
        weights[0] = weights[0] / spread[:, None]
        biases[0] = biases[0] - mean @ weights[0]
        scale = np.concatenate([scale, np.ones(PHASES)])
        weights[-1], biases[-1] = weights[-1] * scale, biases[-1] * scale
        self.weights = [weight.astype(np.float32) for weight in weights]
        self.biases = [bias.astype(np.float32) for bias in biases]

    def act(self, features: list[float]) -> tuple[np.ndarray, int]:
        """Return the command and the phase."""
        x = np.asarray(features)
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = np.maximum(x @ weight + bias, 0.0)
        x = x @ self.weights[-1] + self.biases[-1]
        return x[:-PHASES], int(x[-PHASES:].argmax())


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
        phase = self.expert.controller.phase
        self.features.advance(phase, told.depth)
        self.rows.append((features, action, before, phase))
        return action

    def samples(self) -> Samples:
        """Return all that was seen."""
        features, actions, before, phases = zip(*self.rows, strict=True)
        return Samples(np.array(features), np.array(actions), np.array(before), np.array(phases))


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


def task_of(about: dict[str, Any]) -> Any:
    """Return the task of demonstrations."""
    from seamark.demonstrations.episodes import Task  # noqa: PLC0415

    options = {name: about["options"][name] for name in ("settings", "reward", "dtype")}
    return Task(benchmark=about["benchmark"], expert=about["expert"], **options)


def config_of(task: Any) -> Any:
    """Return the configuration of a task."""
    from seamark.sim import registry  # noqa: PLC0415

    return registry.benchmark(task.benchmark).read(task.settings)


def trained(samples: list[Samples], steps: int, random: np.random.Generator) -> Policy:
    """Return a network that has learned all samples, by Adam (Kingma and Ba 2015)."""
    x, actions, before, phases = (np.concatenate(part) for part in zip(*samples, strict=True))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-3
    scale = actions.std(axis=0) + 1e-3
    x = ((x - mean) / spread).astype(np.float32)
    targets = (actions / scale).astype(np.float32)
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
    return Policy(network, mean, spread, scale)


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


def exported(policy: Policy) -> bytes:
    """Return the network in ONNX's format."""
    from onnx import TensorProto, helper, numpy_helper  # noqa: PLC0415

    nodes, stored, value = [], [], "features"
    for number, (weight, bias) in enumerate(zip(policy.weights, policy.biases, strict=True)):
        stored += [
            numpy_helper.from_array(weight, f"weight{number}"),
            numpy_helper.from_array(bias, f"bias{number}"),
        ]
        names = [value, f"weight{number}", f"bias{number}"]
        value = f"layer{number}"
        nodes.append(helper.make_node("Gemm", names, [value]))
        if number < len(policy.weights) - 1:
            nodes.append(helper.make_node("Relu", [value], [f"rectified{number}"]))
            value = f"rectified{number}"
    joints = policy.biases[-1].size - PHASES
    stored.append(numpy_helper.from_array(np.array([joints, PHASES]), "sizes"))
    nodes.append(helper.make_node("Split", [value, "sizes"], ["command", "phase"], axis=1))

    def described(name: str, size: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, size])

    graph = helper.make_graph(
        nodes,
        "policy",
        [described("features", len(policy.weights[0]))],
        [described("command", joints), described("phase", PHASES)],
        stored,
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    return made.SerializeToString()


def pack(policy: Policy, known: dict[str, list[float]], out: Path) -> None:
    """Write the archive that is submitted; `known` is what the program needs beside the network."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(HERE / "main.py", "main.py")
        archive.writestr("policy.json", json.dumps(known))
        archive.writestr("policy.onnx", exported(policy))


def main() -> None:
    """Train and pack."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("shown", type=Path, help="Demonstrations as Parquet.")
    parser.add_argument("--steps", type=int, default=8000, help="Of the optimiser.")
    parser.add_argument("--out", type=Path, default=Path("imitation.zip"))
    chosen = parser.parse_args()
    began, random = time.process_time(), np.random.default_rng(1)
    task = task_of(json.loads((chosen.shown / "seamark.json").read_text()))
    samples = [*shown(chosen.shown)]
    policy = trained(samples, chosen.steps, random)
    most = np.max([np.abs(each.actions).max(axis=0) for each in samples], axis=0).tolist()
    pack(policy, {"tool_m": tool_of(config_of(task)), "most": most}, chosen.out)
    print(f"Wrote {chosen.out} after {time.process_time() - began:.0f} s of processor time.")


if __name__ == "__main__":
    main()
