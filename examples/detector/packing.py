"""The network of the example, and how it is packed as a detector that can be submitted."""

import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from onnx import TensorProto, helper, numpy_helper

from seamark.sim.detectors.network.layers import ADDED, KEPT, LAST, LAYERS
from seamark.sim.detectors.network.reading import CELLS, OUTPUTS, STRIDE, VIEWS

Layers = dict[str, tuple[np.ndarray, np.ndarray]]  # weights (outputs, inputs, 3, 3) and biases
READING = "seamark.sim.detectors.network.reading"
LIBM = '''"""What the module beside it imports of the simulator's arithmetic."""

from math import exp  # noqa: F401
'''


def exported(layers: Layers) -> bytes:
    """Return the network in ONNX's format."""
    nodes, last = [], "views"
    stored = [numpy_helper.from_array(np.array([1.0, 1.0, 2.0, 2.0], np.float32), "doubled")]
    for name, (_, _, stride) in LAYERS.items():
        parts = [f"{name}.weights", f"{name}.biases"]
        stored += [
            numpy_helper.from_array(array, part)
            for array, part in zip(layers[name], parts, strict=True)
        ]
        if name == LAST:
            nodes.append(helper.make_node("Conv", [last, *parts], [name], pads=[1] * 4))
            continue
        sums = f"{name}.sums"
        strided = {"pads": [1] * 4, "strides": [stride] * 2}
        nodes.append(helper.make_node("Conv", [last, *parts], [sums], **strided))
        nodes.append(helper.make_node("Relu", [sums], [name]))
        last = name
        if name == ADDED:
            nearest = {"mode": "nearest", "coordinate_transformation_mode": "asymmetric"}
            nearest["nearest_mode"] = "floor"
            nodes.append(helper.make_node("Resize", [name, "", "doubled"], ["larger"], **nearest))
            nodes.append(helper.make_node("Add", [KEPT, "larger"], [last := "both"]))

    def described(name: str, *shape: int) -> Any:
        return helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, *shape])

    height, width = (STRIDE * side // 2 for side in CELLS)
    graph = helper.make_graph(
        nodes,
        "detector",
        [described("views", VIEWS, height, width)],
        [described(LAST, OUTPUTS, *CELLS)],
        stored,
    )
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    return made.SerializeToString()


def pack(model: bytes, out: Path) -> None:
    """Write the archive that is submitted."""
    reading = Path(find_spec(READING).origin).read_text("utf-8")
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(Path(__file__).with_name("main.py"), "main.py")
        archive.writestr("reading.py", reading.replace("from seamark.sim.numerics.", "from "))
        archive.writestr("libm.py", LIBM)
        archive.writestr("model.onnx", model)
