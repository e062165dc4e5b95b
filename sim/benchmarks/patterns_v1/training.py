"""Scenes of patterns-v1 to train a detector with: bottoms that no trial of the benchmark shows.

Each scene is drawn as a level is, and its images are those of a level's passage. Its optical depth
is anywhere between those of the first and the last level.
"""

from collections.abc import Iterator

import numpy as np

from seamark.sim.benchmarks.patterns_v1.scenario import draw_scenario
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.engine.labelled_images import LabelledImage, labels_of, training_seed
from seamark.sim.numerics.random_streams import streams

IMAGES = 24  # of a scene, as of a level: painting costs as much as thirty images


def labelled_scene(
    config: PatternsConfiguration, number: int, *, seed: int, images: int
) -> Iterator[LabelledImage]:
    """Yield the first images of a scene, which depend on these values only."""
    entropy = training_seed(seed)
    depth = _depth(config, entropy, number)
    config = config.model_copy(update={"optical_depths": (depth,)})
    scenario = draw_scenario(config, entropy, number, 0)
    camera, altitude_m = scenario.camera, scenario.conditions.altitude_m
    show = camera.colour if config.colour else camera.grey
    size = camera.optics.width, camera.optics.height
    for step in range(images):
        motion = np.concatenate(scenario.path.pose_and_velocity(step * config.control_period_s))
        labels = labels_of(camera.seen(motion), size)
        yield LabelledImage(show(motion, step), labels, number, depth, altitude_m)


def _depth(config: PatternsConfiguration, entropy: int, number: int) -> float:
    """Return the optical depth of a scene, from a stream that the levels do not use."""
    share = float(streams(entropy, number, 0).trial_water.random())
    first, last = config.optical_depths[0], config.optical_depths[-1]
    return first + (last - first) * share
