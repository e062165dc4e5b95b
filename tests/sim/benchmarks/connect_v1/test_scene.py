"""What stands in the scene of connect-v1, and what a trial draws of it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.sim.benchmarks.connect_v1 import scene
from seamark.sim.benchmarks.connect_v1.experiment import EXPERIMENT, Connect
from seamark.sim.benchmarks.connect_v1.settings import MOST_TILT_RAD, ConnectConfiguration
from seamark.sim.benchmarks.intervention.things import SUNK_M
from seamark.sim.benchmarks.intervention.tilt import Tilt
from seamark.sim.control.manipulation import connector
from seamark.sim.engine.trial import run_trial
from seamark.sim.metrics.connection import METRICS, SEATED_M, TIP_M, Connection
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.random_streams import streams
from seamark.sim.recording.telemetry import WORK_INDEX, Rows, digest
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles.linkage import Touchable
from seamark.sim.vehicles.linkage_reading import load_linkage
from tests.sim.benchmarks.attempts import rows_of

CONFIG = ConnectConfiguration.read({"levels": [0.1], "level_duration_s": 5.0})
WHOLE_S = ConnectConfiguration.read({}).level_duration_s


def drawn(trial: int) -> scene.ConnectorDraw:
    return scene.draw_connector(CONFIG, streams(2026, trial, 0))


def shape(work: Workpiece, name: str) -> Touchable:
    shapes = [one for part in work.things for link in part.linkage.links for one in link.shapes]
    return next(one for one in shapes if one.name == name)


def run(controller: str = "scripted", *, seed: int = 2026) -> Rows:
    rows: list[Rows] = []
    program = EXPERIMENT.built_in(controller, CONFIG)
    run_trial("connect-v1", CONFIG, program, seed=seed, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def test_trials_draw_within_what_is_said_and_differ() -> None:
    draws = [drawn(trial) for trial in range(40)]

    for draw in draws:
        assert abs(draw.heading_rad) <= np.pi
        assert scene.LOWEST_M <= draw.height_m <= scene.HIGHEST_M
        assert abs(draw.parked_m - scene.PARKED_M) <= scene.RAIL_M
        assert abs(draw.askew_rad) <= scene.ASKEW_RAD
        assert scene.LIGHTEST_KG <= draw.mass_kg <= scene.HEAVIEST_KG
        assert CONFIG.clearance_least_m <= draw.clearance_m <= CONFIG.clearance_most_m
        assert abs(draw.friction_factor - 1.0) <= CONFIG.friction_spread
    assert len(set(draws)) == len(draws)


def test_the_hole_is_wider_than_the_peg_by_the_clearance_that_was_drawn() -> None:
    draw = drawn(3)
    work = scene.workpiece(draw)
    hole, peg = shape(work, "hole"), shape(work, "peg")

    assert peg.size.value[0] == scene.PEG_M
    assert 2.0 * (hole.size.value[0] - peg.size.value[0]) == pytest.approx(draw.clearance_m)
    assert hole.size.value[1] > SEATED_M


def test_connector_metrics_and_controllers_have_one_length() -> None:
    peg = load_linkage(scene.CONNECTOR).link("peg")
    (cylinder,) = peg.shapes
    tip = peg.joint.place.point.value[2] + cylinder.size.value[1]

    assert tip == pytest.approx(TIP_M)
    assert (connector.TIP_M, connector.PARKED_M) == (TIP_M, scene.PARKED_M)


def test_the_receptacle_is_at_the_origin_of_the_world_which_the_stages_rely_on() -> None:
    draw = drawn(5)
    receptacle, parked = scene.workpiece(draw).things
    mouth = np.array(receptacle.place.point.value)
    attitudes = [
        Rotation.from_euler("xyz", thing.place.turn.value) for thing in (receptacle, parked)
    ]

    assert mouth[:2].tolist() == [0.0, 0.0]
    assert mouth[2] == pytest.approx(scene.target(draw).seabed_m - draw.height_m)
    bore, peg = (attitude.apply([0.0, 0.0, 1.0]) for attitude in attitudes)
    assert np.arccos(bore[2]) == pytest.approx(draw.tilt.angle_rad)
    assert peg == pytest.approx(bore)
    from_mouth = np.array(parked.place.point.value) + TIP_M * peg - mouth
    assert from_mouth @ bore == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(from_mouth) == pytest.approx(draw.parked_m)


def test_the_panel_reaches_from_its_face_into_the_seabed_however_it_is_tilted() -> None:
    draw = drawn(5)
    panel = shape(scene.workpiece(draw), "panel")
    long, wide, half = panel.size.value

    assert panel.place.point.value[2] == pytest.approx(half)
    assert 2.0 * half == pytest.approx(draw.height_m + SUNK_M)
    assert np.hypot(long, wide) * np.sin(MOST_TILT_RAD) < SUNK_M


def test_the_face_that_is_tracked_is_the_top_of_the_panel() -> None:
    draw = drawn(7)

    level, middle = scene.target(draw).top_corners(), scene.target(draw).top_centre()
    tilted = middle + (level - middle) @ draw.tilt.matrix().T

    assert draw.tilt.angle_rad > 0.01
    assert np.allclose(scene.workpiece(draw).corners(), tilted)


def test_a_trial_without_a_tilt_is_the_same_but_level() -> None:
    level = ConnectConfiguration.read({"tilt_spread_rad": 0.0})
    tilted, flat = (scene.draw_connector(config, streams(2026, 4, 0)) for config in (CONFIG, level))

    assert tilted.tilt.angle_rad > 0.0
    assert flat.tilt.matrix().tolist() == np.eye(3).tolist()
    assert replace(tilted, tilt=flat.tilt) == flat


class Steep(Connect):
    """As steep as it may be, to one side or another; and the rest of the draw as told."""

    def __init__(self, axis_rad: float, **drawn: float) -> None:
        super().__init__(METRICS)
        self._tilt, self._drawn = Tilt(angle_rad=MOST_TILT_RAD, axis_rad=axis_rad), drawn

    def _connector(
        self, config: ConnectConfiguration, seed: int, trial: int
    ) -> scene.ConnectorDraw:
        drawn = super()._connector(config, seed, trial)
        return replace(drawn, tilt=self._tilt, **self._drawn)


def rows_on(
    experiment: Connect, entry: str, current_m_s: float, duration_s: float = WHOLE_S
) -> Rows:
    config = ConnectConfiguration.read(
        {"tracker": "truth", "levels": [current_m_s], "level_duration_s": duration_s}
    )
    return rows_of(experiment, config, experiment.built_in(entry, config), seed=2026, trial=0)


def moved_m(rows: Rows) -> float:
    """Return by how much the handle moved at most."""
    handle = rows[:, [WORK_INDEX[f"workpiece_{axis}"] for axis in "xyz"]]
    return float(np.linalg.norm(handle - handle[0], axis=1).max())


AXES_RAD = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0)
# The gusts are the same along each axis: one goes through all of them, the others show a start.
RESTS = [(axis, WHOLE_S if axis == 0.0 else 15.0) for axis in AXES_RAD]


@pytest.mark.slow
def test_the_connector_stands_in_its_parking_place_until_it_is_taken() -> None:
    rows = run("nothing")
    lean = rows[:, [WORK_INDEX["workpiece_roll"], WORK_INDEX["workpiece_pitch"]]]

    assert moved_m(rows) < 1e-3
    assert np.ptp(lean, axis=0).max() < 1e-3
    assert rows[:, WORK_INDEX["work_arm_n"]].max() == 0.0
    assert rows[1:, WORK_INDEX["work_rest_n"]].min() > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("axis_rad", "duration_s"), RESTS)
def test_the_lightest_and_smoothest_stands_on_the_steepest_panel_in_a_current(
    axis_rad: float, duration_s: float
) -> None:
    smoothest = 1.0 - CONFIG.friction_spread
    steep = Steep(axis_rad, mass_kg=scene.LIGHTEST_KG, friction_factor=smoothest)

    assert moved_m(rows_on(steep, "nothing", 0.2, duration_s)) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("axis_rad", "duration_s"), RESTS)
def test_the_posts_keep_it_in_its_place_in_the_strongest_current(
    axis_rad: float, duration_s: float
) -> None:
    attempt = Connection(rows_on(Steep(axis_rad), "nothing", 0.5, duration_s), 0.05)

    assert np.abs(attempt.depth_m).max() < 0.01
    assert np.abs(attempt.off_m - attempt.off_m[0]).max() < 0.015


@pytest.mark.slow
@pytest.mark.parametrize(
    "axis_rad", [1.0, *(pytest.param(axis, marks=pytest.mark.long) for axis in (-3.0, -1.0))]
)
def test_an_oracle_plugs_it_along_the_axis_of_the_steepest_bore(axis_rad: float) -> None:
    rows = rows_on(Steep(axis_rad), "oracle", 0.1)
    attempt = Connection(rows, 0.05)
    start, end = (
        Rotation.from_euler(
            "xyz", rows[row, [WORK_INDEX[f"workpiece_{a}"] for a in ("roll", "pitch", "yaw")]]
        ).apply([0.0, 0.0, 1.0])
        for row in (0, -1)
    )

    assert attempt.progress.credit == 1.0
    assert attempt.depth_m[-1] > SEATED_M
    assert np.arccos(start[2]) == pytest.approx(MOST_TILT_RAD, abs=1e-6)
    assert np.arccos(start @ end) < 0.06  # it leans in the bore by its clearance, and no more
    assert np.arccos(end[2]) > 0.08


@pytest.mark.slow
def test_the_same_trial_gives_the_same_bytes_twice() -> None:
    assert digest(run()) == digest(run())
    assert digest(run()) != digest(run(seed=2027))


def test_a_greatest_clearance_below_the_least_is_refused() -> None:
    with pytest.raises(ConfigurationInvalid, match="Greatest clearance"):
        ConnectConfiguration.read({"clearance_least_m": 0.005, "clearance_most_m": 0.004})


def test_a_panel_on_which_a_connector_would_not_stand_is_refused() -> None:
    assert CONFIG.tilt_spread_rad == MOST_TILT_RAD
    with pytest.raises(ConfigurationInvalid, match=r"Tilt.*at most 0\.14 rad, not 0\.15 rad"):
        ConnectConfiguration.read({"tilt_spread_rad": 0.15})


def test_programs_are_told_of_the_panel_but_not_what_was_drawn() -> None:
    told = CONFIG.for_program()

    assert told["face_m"] == (0.6, 0.45)
    assert not {"levels", "azimuth_spread_rad", "height_m", "heading_rad", "mass_kg"} & set(told)
