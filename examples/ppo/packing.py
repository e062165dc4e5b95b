"""How the policy is packed as a controller that can be submitted, and what it does in a sandbox."""

import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from features import FEATURES, THRUST
from onnx import TensorProto, helper, numpy_helper

from seamark.cli.solutions import isolation_level
from seamark.programs import preparation
from seamark.sandbox.box import Box
from seamark.sandbox.limits import Limits
from seamark.sim import registry
from seamark.sim.vehicles import load

Layer = tuple[np.ndarray, np.ndarray]  # weights (inputs, outputs) and biases
BENCHMARK = "currents-v2"
FILES = ("main.py", "features.py")


def exported(layers: list[Layer]) -> bytes:
    """Return the network in ONNX's format: hyperbolic tangents between the layers."""
    nodes, stored, value = [], [], "features"
    for number, layer in enumerate(layers):
        names = [f"weights{number}", f"biases{number}"]
        stored += [
            numpy_helper.from_array(np.ascontiguousarray(array, np.float32), name)
            for array, name in zip(layer, names, strict=True)
        ]
        last = number == len(layers) - 1
        sums = "actions" if last else f"sums{number}"
        nodes.append(helper.make_node("Gemm", [value, *names], [sums]))
        if not last:
            value = f"layer{number}"
            nodes.append(helper.make_node("Tanh", [sums], [value]))

    def described(name: str, size: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, size])

    graph = helper.make_graph(
        nodes,
        "policy",
        [described("features", FEATURES)],
        [described("actions", layers[-1][1].size)],
        stored,
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    return made.SerializeToString()


def pack(layers: list[Layer], out: Path) -> None:
    """Write the archive that is submitted."""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in FILES:
            archive.write(Path(__file__).with_name(name), name)
        archive.writestr("policy.onnx", exported(layers))


@contextmanager
def boxed(archive: Path, vehicle: str) -> Iterator[Callable[[np.ndarray], np.ndarray]]:
    """Yield what the archive answers in its sandbox to each observation (29,): a command (4,)."""
    program = preparation.prepare(archive.read_bytes(), archive.name)
    definition = registry.benchmark(BENCHMARK)
    config = definition.read({"vehicle": vehicle})
    numbers = THRUST.start + len(load(vehicle).thrusters)
    with Box(limits=Limits(), isolation=isolation_level()) as box:
        layout = definition.load().layout(config)
        box.load(program.content, program.name, config.for_program(), layout)
        box.reset({"index": 0})
        yield lambda observation: np.array(box.step(observation[:numbers]))
