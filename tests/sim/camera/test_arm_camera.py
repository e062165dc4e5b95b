"""Cameras of a vehicle with an arm: they show what the simulation and its rows have."""

import numpy as np
import pytest

from seamark.sim import registry
from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.replay import NoCameraOnArm, Replay
from seamark.sim.recording.telemetry import INDEX, width_for
from tests.sim.engine.test_arm import BENCHMARK, SEED, SHORT, Moving, run

MOVING = (0.0, 0.0, 0.0, 0.0, 0.3, -0.3, -0.1, 0.0, -0.1)
AT_HOME = np.array([0.0, 1.0, 2.5, 0.0, 0.3])


def replay(**settings: object) -> Replay:
    return Replay(BENCHMARK, registry.benchmark(BENCHMARK).read(SHORT | settings), lambda _: SEED)


def motion(z: float = 1.6, joints: np.ndarray = AT_HOME) -> np.ndarray:
    still = np.zeros(12 + 2 * len(joints))
    still[2], still[12 : 12 + len(joints)] = z, joints
    return still


@pytest.mark.slow
def test_images_that_are_rendered_again_from_rows_are_those_of_the_run() -> None:
    config = registry.benchmark(BENCHMARK).read(SHORT)
    experiment = registry.benchmark(BENCHMARK).load()
    world = experiment.world(config, seed=SEED, trial=0, level=0)
    loop = ClosedLoop(world, Moving(MOVING), trial=0, level=0)
    row = np.zeros(width_for(8, arm=True))
    again = replay()

    for step in range(30):
        loop.sense(step, row)
        live = world.camera.colour(loop.motion(), step)
        assert again.frame(row).colour().tobytes() == live.tobytes()
        loop.act(step, row)


def test_the_vehicles_camera_shows_the_same_scene_as_without_an_arm() -> None:
    seeing = replay().camera(0, 0)
    bare = replay(arm="none").camera(0, 0)

    one, other = seeing.grey(motion(), 0), bare.grey(motion()[:12], 0)

    assert isinstance(seeing, ArmCamera)
    assert not isinstance(bare, ArmCamera)
    assert np.abs(one.astype(float) - other).mean() < 0.5
    assert seeing.corners(motion()).tobytes() == bare.corners(motion()[:12]).tobytes()


def test_the_camera_on_the_arm_sees_the_hand_move_and_the_bottom_near() -> None:
    camera = replay().camera(0, 0)
    assert isinstance(camera, ArmCamera)
    closed = AT_HOME - np.array([0.0, 0.0, 0.0, 0.0, 0.3])
    turned = AT_HOME + np.array([0.0, 0.0, 0.0, 1.5, 0.0])

    home, again, shut, rolled = (
        camera.colour_on_arm(motion(joints=joints), 0)
        for joints in (AT_HOME, AT_HOME, closed, turned)
    )

    assert home is not None
    assert again is not None
    assert home.tobytes() == again.tobytes()
    for other in (shut, rolled):
        assert other is not None
        assert 0.001 < (np.abs(home.astype(int) - other).max(axis=2) > 30).mean() < 0.3


def test_the_lamp_of_the_vehicle_lights_what_the_camera_on_the_arm_sees() -> None:
    ahead, aside = (np.array([turn, 0.4, 2.8, 0.0, 0.3]) for turn in (0.0, 2.5))

    bright = []
    for lamp, joints in ((0.0, ahead), (6.0, ahead), (6.0, aside)):
        camera = replay(light_level=0.01, lamp=lamp).camera(0, 0)
        assert isinstance(camera, ArmCamera)
        image = camera.colour_on_arm(motion(z=3.0, joints=joints), 0)
        assert image is not None
        bright.append(image.mean())

    assert bright[1] > bright[0] + 5.0
    assert bright[2] > 1.2 * bright[1]  # it does not turn with the arm


def test_a_run_tracks_the_target_with_an_arm_as_well_as_without() -> None:
    rows = run(Moving((0.0, 0.0, 0.0, 0.0)), tracker="esm")

    assert np.nanmax(rows[10:, INDEX["tracker_error"]]) < 2.0


def test_a_vehicle_without_an_arm_has_no_camera_on_one() -> None:
    rows = run(Moving((0.0, 0.0, 0.0, 0.0)), arm="none")

    with pytest.raises(NoCameraOnArm, match="no camera"):
        replay(arm="none").frame(rows[0]).on_arm()
