"""A controller for currents-v2 that steers by the images of its camera, and not by the tracker.

`train.py` packs it. Beside it are eye.onnx, the network that finds the target, reckoning.py, which
remembers where that is, and what examples/ppo has packed: policy.onnx, the network that steers, and
features.py, what it sees.
"""

from pathlib import Path

import numpy as np
import onnxruntime
from features import ERROR, STEPS, VISIBLE, Features, row
from reckoning import Reckoning

LEAST_CONTRAST = 1.0  # grey levels; noise alone has less
ALONE = np.array([0])  # one vehicle, the first


def loaded(name):
    """Return the network of a file."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1  # networks so small take more time with two
    return onnxruntime.InferenceSession(str(Path(__file__).with_name(name)), options)


def pooled(image, rows, columns):
    """Return means of rows x columns parts of an image, minus its own, in units of its contrast."""
    height, width = image.shape
    means = image.reshape(rows, height // rows, columns, width // columns).mean(axis=(1, 3))
    contrast = max(means.std(), LEAST_CONTRAST)
    return ((means - means.mean()) / contrast).astype(np.float32)


def sight(output, height, width):
    """Return the target's centre minus the image's [px], right and down; None without a target.

    The output (3, rows, columns) has for each cell of the image a score, and how many cells to the
    right and down from its middle the target is. No target has a score of zero.
    """
    _, rows, columns = output.shape
    row, column = divmod(int(output[0].argmax()), columns)
    score, right, down = output[:, row, column].tolist()
    if score <= 0.0:
        return None
    x, y = (column + 0.5 + right) / columns, (row + 0.5 + down) / rows
    return (x - 0.5) * width, (y - 0.5) * height


class Controller:
    def __init__(self, config):
        if config.get("images") not in ("vehicle", "both"):
            raise ValueError("this controller looks at images: set images to vehicle")
        self.eye, self.hand = loaded("eye.onnx"), loaded("policy.onnx")
        self.reckoning = Reckoning(config)
        self.reset(None)

    def reset(self, level):
        self.reckoning.reset()
        self.features = Features(1)
        self.image_t, self.step_number = -1.0, 0

    def step(self, observation):
        self.reckoning.move(observation)
        if observation.image_t != self.image_t:
            self.image_t = observation.image_t
            self.look(observation.images["vehicle"])
        if self.step_number % STEPS == 0:
            told = row(observation)
            told[0, ERROR], told[0, VISIBLE] = self.reckoning.error(), 1.0
            seen = self.features.see(told, ALONE)
            [actions] = self.hand.run(None, {"features": seen})
            self.command = self.features.command(actions)[0].tolist()
        self.step_number += 1
        return self.command

    def look(self, image):
        """Remember where the target is in an image, if it is there."""
        [given] = self.eye.get_inputs()
        image_of_eye = pooled(image, *given.shape[2:])
        [output] = self.eye.run(None, {"image": image_of_eye[None, None]})
        if (found := sight(output[0], *image.shape)) is not None:
            self.reckoning.see(self.image_t, found)
