"""A learned detector for patterns-v1: a network that tells where objects are and what they are.

`train.py` packs it. Beside it in the archive are model.onnx, the network, and reading.py, what the
network gets of an image and what its output means.
"""

from pathlib import Path

import numpy as np
import onnxruntime
from reading import answers, views


class Detector:
    def __init__(self, config):
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        model = Path(__file__).with_name("model.onnx")
        self.session = onnxruntime.InferenceSession(str(model), options)

    def detect(self, image):
        if image.ndim == 3:
            image = np.ascontiguousarray(image[:, :, 1])  # water absorbs red light first
        [output] = self.session.run(None, {"views": views(image)[None]})
        return answers(output[0])
