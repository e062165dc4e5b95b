"""Echoes: where they come from, how strong they are, and what is in a shadow."""

import math

import numpy as np
import pytest

from seamark.sim.camera.seabed import hash01
from seamark.sim.multibody.assembly import Look
from seamark.sim.sonar import acoustics
from seamark.sim.sonar.device import APERTURE_RAD, Device
from seamark.sim.sonar.seabed_strength import TILE, strength_tile
from seamark.sim.sonar.sonar import receiver_of
from tests.sim.sonar.scenes import HERE, MU, ahead, ranges, solid, sonar

WALL_M = 9.5  # [m] before the sonar
EDGE_RAD = 0.5 * APERTURE_RAD


def wall(away_m: float = WALL_M) -> Look:
    return solid("box", (1.0, 200.0, 200.0), (away_m + 0.5, 0.0, 0.0))


@pytest.mark.parametrize("beam", [0, 40, 127, 128, 200, 255])
def test_a_wall_returns_from_its_distance_along_the_beam_to_the_edges_of_the_aperture(
    beam: int,
) -> None:
    facing = sonar([wall()], range_m=25.0)

    first, last = ranges(facing, beam)

    nearest = WALL_M / math.cos(facing.device.azimuth_rad(beam))
    wide = facing.device.bin_m + nearest * 0.01 * abs(math.tan(facing.device.azimuth_rad(beam)))
    assert first == pytest.approx(nearest, abs=wide)
    assert last == pytest.approx(nearest / math.cos(EDGE_RAD), abs=wide)


@pytest.mark.parametrize(("height", "tilt"), [(2.0, 0.3), (5.4, 0.35), (3.0, 0.6)])
def test_the_seabed_begins_at_the_lower_edge_of_the_aperture_and_ends_at_the_upper_one(
    height: float, tilt: float
) -> None:
    looking = sonar(seabed_m=height, tilt_rad=tilt, range_m=60.0, bins=1024)

    first, last = ranges(looking, ahead(looking))

    assert first == pytest.approx(height / math.sin(tilt + EDGE_RAD), abs=looking.device.bin_m)
    assert last == pytest.approx(
        min(height / math.sin(tilt - EDGE_RAD), 60.0), abs=2.0 * looking.device.bin_m
    )


def test_a_level_sonar_sees_no_seabed_below_its_aperture() -> None:
    assert not sonar(seabed_m=4.0, range_m=20.0).echoes(HERE).any()  # from 23 m on


def test_the_shadow_of_a_box_ends_where_the_ray_over_its_top_meets_the_seabed() -> None:
    height, back, tall = 4.0, 9.0, 1.0
    box = solid("box", (0.5, 2.0, 2.0 * tall), (back - 0.25, 0.0, height))
    looking = sonar([box], seabed_m=height, tilt_rad=0.45, range_m=20.0)

    echoes = looking.echoes(HERE)[ahead(looking)]
    first, last = (round(x / looking.device.bin_m) for x in ranges(looking, ahead(looking)))
    dark = first + np.flatnonzero(echoes[first:last] == 0.0)

    # Similar triangles: what is h - t above the seabed's shadow at the box is h at the sonar.
    end = back * height / (height - tall)
    assert dark[-1] * looking.device.bin_m == pytest.approx(math.hypot(end, height), abs=0.1)
    # It begins at the far edge of the top, beyond which nothing of the box returns.
    start = math.hypot(back, height - tall)
    assert dark[0] * looking.device.bin_m == pytest.approx(start, abs=0.1)
    assert len(dark) == dark[-1] - dark[0] + 1


def test_what_is_behind_a_wall_returns_nothing() -> None:
    hidden = solid("box", (1.0, 1.0, 1.0), (14.0, 0.0, 0.0))

    alone, both = sonar([wall()]), sonar([wall(), hidden])

    assert sonar([hidden]).echoes(HERE).any()
    assert both.echoes(HERE).tobytes() == alone.echoes(HERE).tobytes()


def test_a_pipe_returns_from_its_side() -> None:
    across = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    pipe = solid("cylinder", (40.0, 0.6, 0.6), (8.0, 0.0, 0.0), across)
    looking = sonar([pipe])

    assert ranges(looking, ahead(looking))[0] == pytest.approx(8.0 - 0.3, abs=0.05)


def test_a_wall_returns_what_lamberts_rule_says() -> None:
    facing = sonar([wall()], range_m=12.0)
    beam = ahead(facing)

    total = float(facing.echoes(HERE)[beam].sum())

    e = (np.arange(4000) + 0.5) / 4000 * APERTURE_RAD - EDGE_RAD
    squarely = np.cos(e) * math.cos(facing.device.azimuth_rad(beam))
    pattern = 0.25 ** ((e / EDGE_RAD) ** 2)  # half at the edge, out and back
    expected = MU * facing.device.spacing_rad * APERTURE_RAD
    assert total == pytest.approx(expected * np.mean(squarely * np.cos(e) * pattern), rel=2e-3)


def test_energy_does_not_depend_on_the_number_of_rays() -> None:
    things = [
        solid("box", (1.0, 2.0, 2.0), (10.0, 1.0, 4.5)),
        solid("sphere", (1.5, 1.5, 1.5), (9.0, -4.0, 4.0)),
    ]
    options = {"seabed_m": 5.0, "tilt_rad": 0.45, "range_m": 60.0}

    totals = [
        float(sonar(things, rays=rays, **options).echoes(HERE).sum())  # type: ignore[arg-type]
        for rays in (31, 63, 127, 255)
    ]

    assert np.ptp(totals) / np.mean(totals) < 0.01


def test_the_echo_of_a_small_box_falls_with_the_fourth_power_of_its_distance() -> None:
    def level(away_m: float) -> float:
        energies = []
        for shift in np.linspace(0.0, 0.3, 12):  # a box lies between rays in many ways
            at = away_m + 0.2, shift, 0.7 * shift
            facing = sonar([solid("box", (0.4, 0.4, 0.4), at)], range_m=24.0)
            per_range = facing.echoes(HERE).sum(axis=0)
            energies.append(float((per_range * receiver_of(facing.device).loss[0]).sum()))
        absorbed = acoustics.power_of_ten(-0.2 * acoustics.absorption_db_m(720.0) * away_m)
        return float(np.mean(energies)) / absorbed

    slope = math.log(level(16.0) / level(8.0)) / math.log(2.0)

    assert slope == pytest.approx(-4.0, abs=0.08)


def test_the_gain_over_time_undoes_what_a_small_target_loses() -> None:
    receiver = receiver_of(Device(range_m=30.0, tilt_rad=0.3))
    away = (np.arange(400) + 0.5) * 30.0 / 400

    # Of a target of -40 dB, whose intensity at 1 m is 1e-4 of that of the ping.
    echo = 1e-4 * receiver.loss[0].astype(np.float64) / away**2
    levels = receiver.gain[0] * np.sqrt(echo)

    assert levels == pytest.approx(255.0 * 10.0 ** ((-40.0 + 32.0) / 20.0), rel=1e-4)


def test_sea_water_absorbs_what_francois_and_garrison_say() -> None:
    # Their equation at 10 degrees C and 35, pH 8 has 0.04 dB/m at 100 kHz and 0.3 dB/m at 1 MHz.
    assert acoustics.absorption_db_m(100.0) == pytest.approx(0.036, abs=0.004)
    assert acoustics.absorption_db_m(720.0) == pytest.approx(0.21, abs=0.03)
    assert acoustics.absorption_db_m(1000.0) > acoustics.absorption_db_m(720.0)


def test_places_of_the_seabed_differ_and_their_mean_is_one() -> None:
    tile = strength_tile()

    assert tile.mean() == pytest.approx(1.0, rel=1e-4)
    assert 0.3 < tile.std() < 1.5
    stone = max(
        ((i, j) for i in range(TILE) for j in range(TILE)), key=lambda at: tile[at[1], at[0]]
    )
    assert hash01(stone[0], stone[1], 51) < 0.0006
