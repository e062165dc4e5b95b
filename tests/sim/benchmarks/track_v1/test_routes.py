"""The routes: all of one length, from the start on, within the depths, and each another one."""

import numpy as np
import pytest

from seamark.sim.benchmarks.track_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.track_v1.routes import draw_route
from seamark.sim.benchmarks.track_v1.settings import SEABED_M, TrackConfiguration
from seamark.sim.control.observation import ROUTE_POINTS
from seamark.sim.metrics.following import REACH_M, REJOIN_M
from seamark.sim.numerics.polyline import starts_of
from seamark.sim.settings.route import HELIX, KINDS

START = np.array([1.0, -2.0, 14.0])
CONFIG = TrackConfiguration.read({})


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(40))
def test_a_route_has_its_length_begins_at_the_start_and_stays_off_bottom_and_surface(
    kind: str, seed: int
) -> None:
    route = draw_route(kind, 30.0, START, np.random.default_rng(seed))

    assert route.shape == (ROUTE_POINTS, 3)
    assert route[0].tolist() == START.tolist()
    assert starts_of(route)[-1] == pytest.approx(30.0)
    assert route[:, 2].min() > 8.0
    assert route[:, 2].max() < SEABED_M - 3.0


@pytest.mark.parametrize("seed", range(40))
def test_the_turns_of_a_helix_are_out_of_reach_of_each_other(seed: int) -> None:
    route = draw_route(HELIX, 30.0, START, np.random.default_rng(seed))
    starts = starts_of(route)

    for point, along in zip(route, starts, strict=True):
        away = np.abs(starts - along) > REJOIN_M
        assert np.linalg.norm(route[away] - point, axis=1).min() > REACH_M


def test_every_level_and_every_trial_has_a_route_of_its_own() -> None:
    routes = {
        EXPERIMENT.course(CONFIG, seed=5, trial=trial, level=level).route_m.tobytes()
        for trial in range(8)
        for level in range(5)
    }

    assert len(routes) == 40


def test_vehicles_and_kinds_of_routes_take_turns() -> None:
    chosen = [CONFIG.for_trial(trial) for trial in range(8)]

    assert len({(one.vehicle, one.route) for one in chosen}) == 8
    assert [one.vehicle for one in chosen[:2]] == ["girona500", "bluerov2-heavy-v2"]


def test_a_level_draws_where_it_is_said_to_start_within_the_bound() -> None:
    errors = [
        np.hypot(*EXPERIMENT.course(CONFIG, seed=seed, trial=0, level=0).start_error_m)
        for seed in range(60)
    ]

    assert max(errors) <= CONFIG.start_error_m
    assert np.median(errors) == pytest.approx(CONFIG.start_error_m / np.sqrt(2.0), rel=0.2)
