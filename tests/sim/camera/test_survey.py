"""Depth and labels of the pixels, beside rays against the box's planes."""

import numpy as np
import pytest

from seamark.sim.camera import Camera, Optics, Target, Water, start_pose
from seamark.sim.camera.survey import SEABED, TARGET
from tests.sim.camera.conftest import Reference

OPTICS = Optics(width=84, height=60, focal_px=64.0)
START = start_pose(OPTICS, Target(), 1.5)


@pytest.mark.parametrize(
    "moved", [(0, 0, 0, 0, 0, 0), (0.1, -0.1, 0.4, 0.1, -0.1, 1.1), (2, 2, 0, 0, 0, 0)]
)
def test_depth_and_labels_are_those_of_rays(moved: tuple[float, ...]) -> None:
    pose, target = START + np.array(moved), Target()
    reference = Reference(OPTICS, Water(), target, 1)
    v, u = (each.ravel().astype(float) for each in np.indices((OPTICS.height, OPTICS.width)))
    depth, face, _, _ = reference.hits(*reference.rays(pose, u, v))

    found = Camera(OPTICS, Water(), target, noise_seed=1).survey(pose)

    labels = np.where(face < 0, SEABED, TARGET).reshape(found.labels.shape)
    assert (found.labels != labels).sum() <= 2  # a centre on an edge may fall on either side
    same = found.labels == labels
    np.testing.assert_allclose(found.depth[same], depth.reshape(labels.shape)[same], rtol=1e-4)
    assert (labels == TARGET).any() == (moved[0] < 1)
