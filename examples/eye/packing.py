"""How eye and hand are packed as a controller that can be submitted, and what it does in a box."""

import re
import zipfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from onnx import TensorProto, helper, numpy_helper

from seamark.cli.solutions import isolation_level
from seamark.programs import preparation
from seamark.sandbox.box import Box
from seamark.sandbox.limits import Limits
from seamark.sim import registry
from seamark.sim.camera.optics import MOUNT_M
from seamark.sim.control.observation import VEHICLE_CAMERA, Images, Observation
from seamark.sim.control.position.pixels.controller import Controller
from seamark.sim.control.position.pixels.eye import COLUMNS, HEIGHT, LAYERS, OUTPUTS, ROWS, WIDTH
from seamark.sim.engine.program import Command
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics.constants import TARGET_HEIGHT_M

Weights = Mapping[str, np.ndarray]
BENCHMARK = "currents-v2"
OF_THE_HAND = ("features.py", "policy.onnx")
SEED = 1_000_001
RECKONING = "seamark.sim.control.position.pixels.reckoning"
OF_SIMULATOR = re.compile(r"from seamark\.sim\.[\w.]+ import")
SIMULATOR = f'''"""What the module beside it imports of the simulator."""

from math import cos, sin
from types import SimpleNamespace

MOUNT_M = {MOUNT_M}  # [m] of the camera in the body
TARGET_HEIGHT_M = SimpleNamespace(scalar={TARGET_HEIGHT_M.scalar})
Observation = None  # its type


def sincos(angle):
    """Return sine and cosine."""
    return sin(angle), cos(angle)
'''


def exported(weights: Weights) -> bytes:
    """Return the eye in ONNX's format: from images (1, 1, 60, 80) to cells (1, 3, 15, 20)."""
    nodes, value = [], "image"
    for number, (_, _, stride) in enumerate(LAYERS):
        last = number == len(LAYERS) - 1
        given = [value, f"eye_weights{number}", f"eye_biases{number}"]
        sums = "cells" if last else f"sums{number}"
        window = {"pads": [1] * 4, "strides": [stride] * 2}
        nodes.append(helper.make_node("Conv", given, [sums], **window))
        if not last:
            value = f"layer{number}"
            nodes.append(helper.make_node("Relu", [sums], [value]))

    def described(name: str, *shape: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, *shape])

    graph = helper.make_graph(
        nodes,
        "eye",
        [described("image", 1, HEIGHT, WIDTH)],
        [described("cells", OUTPUTS, ROWS, COLUMNS)],
        [
            numpy_helper.from_array(array, name)
            for name, array in weights.items()
            if name.startswith("eye_")
        ],
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    return made.SerializeToString()


def pack(weights: Weights, hand: Path, out: Path) -> None:
    """Write the archive that is submitted; the hand is packed as `examples/ppo` has packed it."""
    reckoning = Path(find_spec(RECKONING).origin).read_text("utf-8")
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive, zipfile.ZipFile(hand) as ppo:
        archive.write(Path(__file__).with_name("main.py"), "main.py")
        archive.writestr("reckoning.py", OF_SIMULATOR.sub("from simulator import", reckoning))
        archive.writestr("simulator.py", SIMULATOR)
        archive.writestr("eye.onnx", exported(weights))
        for name in OF_THE_HAND:
            archive.writestr(name, ppo.read(name))


class Beside:
    """The program in a box steers; at each step the entry says what it would have done.

    The entry remembers what was done. By itself, the memory of commands would make a difference of
    rounding grow.
    """

    def __init__(self, box: Box, entry: Controller) -> None:
        self.box, self.entry = box, entry
        self.images: Images = {}
        self.commands: list[tuple[Command, Sequence[float]]] = []  # of program and entry

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Begin a level."""
        self.box.reset(level)
        self.entry.reset(level)

    def show(self, images: Images) -> None:
        """Give both the newest images."""
        self.box.show(images)
        self.images = images

    def step(self, values: np.ndarray) -> Command:
        """Return the command of the program."""
        done = self.box.step(values)
        self.commands.append((done, self.entry.step(Observation(values, images=self.images))))
        self.entry.hand.command = done[0], done[1], done[3]
        return done


def beside(archive: Path, weights: Weights, vehicle: str, **settings: Any) -> np.ndarray:
    """Return the commands of archive and entry with the same weights, (2, steps, 4) [m/s, rad/s].

    The archive steers the vehicle from its box through a trial that no training meets.
    """
    program = preparation.prepare(archive.read_bytes(), archive.name)
    definition = registry.benchmark(BENCHMARK)
    config = definition.read({"vehicle": vehicle, "images": VEHICLE_CAMERA} | settings)
    with Box(limits=Limits(), isolation=isolation_level()) as box:
        given = config.for_program()
        box.load(program.content, program.name, given, definition.load().layout(config))
        both = Beside(box, Controller(given, weights))
        run_trial(BENCHMARK, config, both, seed=SEED, trial=0, on_rows=lambda _rows: None)
    return np.array(both.commands).transpose(1, 0, 2)
