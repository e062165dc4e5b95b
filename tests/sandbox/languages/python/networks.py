"""Small networks in ONNX's format, as a learned controller or detector exports them."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from onnx import NodeProto, TensorProto, helper, numpy_helper

INPUTS, HIDDEN, OUTPUTS = 3, 64, 4
IMAGE = (240, 320)  # [px] height and width
CLASSES, LAYERS = 8, 4


def weights(seed: int = 7) -> tuple[np.ndarray, np.ndarray]:
    """Return the two matrices of the policy: (3, 64) and (64, 4) float32."""
    source = np.random.default_rng(seed)
    first = source.standard_normal((INPUTS, HIDDEN)) / np.sqrt(INPUTS)
    second = source.standard_normal((HIDDEN, OUTPUTS)) / np.sqrt(HIDDEN)
    return first.astype(np.float32), second.astype(np.float32)


def policy() -> bytes:
    """Return a perceptron with one hidden layer: tanh(x @ first) @ second."""
    first, second = weights()
    nodes = [
        helper.make_node("MatMul", ["x", "first"], ["before"]),
        helper.make_node("Tanh", ["before"], ["hidden"]),
        helper.make_node("MatMul", ["hidden", "second"], ["y"]),
    ]
    inputs, outputs = {"x": (1, INPUTS)}, {"y": (1, OUTPUTS)}
    return _model(nodes, inputs, outputs, {"first": first, "second": second})


def kernels(seed: int = 8) -> list[np.ndarray]:
    """Return the kernels of the heat map: 3 x 3, from 1 over 16, 32 and 64 to 8 channels."""
    source, channels = np.random.default_rng(seed), (1, 16, 32, 64, CLASSES)
    return [
        (source.standard_normal((after, before, 3, 3)) / np.sqrt(9 * before)).astype(np.float32)
        for before, after in pairwise(channels)
    ]


def heat_map() -> bytes:
    """Return a convolutional network: an image in, a map of each class with 1/16 of its side."""
    nodes, last = [], "x"
    for k in range(LAYERS):
        strided = {"pads": [1, 1, 1, 1], "strides": [2, 2]}
        nodes.append(helper.make_node("Conv", [last, f"w{k}"], [f"c{k}"], **strided))
        last = "y" if k == LAYERS - 1 else f"r{k}"
        nodes.append(helper.make_node("Relu", [f"c{k}"], [last]))
    height, width = IMAGE
    inputs, outputs = {"x": (1, 1, *IMAGE)}, {"y": (1, CLASSES, height // 16, width // 16)}
    return _model(nodes, inputs, outputs, {f"w{k}": one for k, one in enumerate(kernels())})


def _model(
    nodes: list[NodeProto],
    inputs: Mapping[str, tuple[int, ...]],
    outputs: Mapping[str, tuple[int, ...]],
    weights: Mapping[str, np.ndarray],
) -> bytes:
    """Return a network of float32 as a file; inputs and outputs with their shapes."""
    given, got = (
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in ends]
        for ends in (inputs.items(), outputs.items())
    )
    stored = [numpy_helper.from_array(values, name) for name, values in weights.items()]
    graph = helper.make_graph(nodes, "network", given, got, stored)
    opsets = [helper.make_opsetid("", 17)]
    made = helper.make_model(graph, opset_imports=opsets, ir_version=9)
    return bytes(made.SerializeToString())
