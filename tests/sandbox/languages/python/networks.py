"""A small network in ONNX's format, as a learned controller exports it."""

import numpy as np
from onnx import TensorProto, helper, numpy_helper

INPUTS, HIDDEN, OUTPUTS = 3, 64, 4


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
    shape = helper.make_tensor_value_info
    graph = helper.make_graph(
        nodes,
        "policy",
        [shape("x", TensorProto.FLOAT, [1, INPUTS])],
        [shape("y", TensorProto.FLOAT, [1, OUTPUTS])],
        [numpy_helper.from_array(first, "first"), numpy_helper.from_array(second, "second")],
    )
    opsets = [helper.make_opsetid("", 17)]
    made = helper.make_model(graph, opset_imports=opsets, ir_version=9)
    return bytes(made.SerializeToString())
