"""Images of the sonar: speckle, noise, the same bits everywhere, and the fan for people."""

import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera.camera import noise_bank
from seamark.sim.sonar.device import Device
from seamark.sim.sonar.display import fan_shape, in_colour, to_fan
from seamark.sim.sonar.sonar import Sonar, pattern_of
from seamark.sim.sonar.speckle import Fields, Receiver, receive
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here
from tests.sim.sonar.scenes import HERE, solid, sonar

BEAMS, BINS = 256, 400
DEVICE = Device(range_m=20.0, tilt_rad=0.3)
PROGRAM = """
import hashlib
from tests.sim.sonar.scenes import HERE, solid, sonar

things = [
    solid("box", (1.0, 0.6, 0.8), (9.0, 1.0, 4.6)),
    solid("cylinder", (4.0, 0.4, 0.4), (8.0, -3.0, 4.8)),
    solid("sphere", (0.5, 0.5, 0.5), (7.0, 0.5, 4.5)),
]
looking = sonar(things, seabed_m=5.0, tilt_rad=0.4)
for frame in (0, 7):
    print(hashlib.sha256(looking.image(HERE, frame).tobytes()).hexdigest())
"""


def speckled(pattern: list[float], level: float = 40.0) -> NDArray[np.float64]:
    """Images (frames, bins, beams) of a mean intensity that is the same everywhere."""
    beyond = len(pattern) // 2
    passed = sum(tap * tap for tap in pattern)
    receiver = Receiver(
        np.array(pattern, np.float32),
        np.ones((1, BINS), np.float32),
        0.0,
        np.full((1, BINS), level / np.sqrt(passed), np.float32),
    )
    beams = BEAMS + 2 * beyond
    fields = Fields(
        np.zeros((beams, BINS), np.float32),
        np.zeros((beams, BINS), np.float32),
        np.zeros(BINS, np.int32),
    )
    echoes, bank = np.ones((beams, BINS), np.float32), noise_bank(1, BINS)[None]
    images = np.zeros((6, BINS, BEAMS), np.uint8)
    for frame, image in enumerate(images):
        receive(echoes, receiver, bank, (1, frame), fields, image)
    return images.astype(np.float64)


@pytest.mark.parametrize("pattern", [[1.0], pattern_of(DEVICE).tolist()], ids=["one", "beam"])
def test_speckle_has_the_contrast_of_many_scatterers(pattern: list[float]) -> None:
    amplitude = speckled(pattern)
    intensity = amplitude**2

    # Rayleigh: sqrt(4 / pi - 1); exponential: 1.
    assert amplitude.std() / amplitude.mean() == pytest.approx(0.5227, rel=0.01)
    assert intensity.std() / intensity.mean() == pytest.approx(1.0, rel=0.02)
    assert intensity.mean() == pytest.approx(40.0**2, rel=0.02)


def test_speckle_is_as_wide_as_a_beam_and_as_long_as_a_bin() -> None:
    intensity = speckled(pattern_of(DEVICE).tolist()) ** 2
    varying = intensity - intensity.mean()

    def correlation(bins: int, beams: int) -> float:
        moved = varying[:, bins:, beams:] * varying[:, : BINS - bins, : BEAMS - beams]
        return float(moved.mean() / varying.var())

    assert correlation(0, 1) > 0.5  # half of a beam's width aside
    assert abs(correlation(0, 6)) < 0.05
    assert abs(correlation(1, 0)) < 0.02


def test_open_water_shows_noise_that_the_gain_raises_with_range() -> None:
    image = sonar(range_m=60.0).image(HERE, 0).astype(np.float64)

    assert image[300:].mean() > 1.5 * image[200:250].mean() > 0.0
    assert image[:40].max() == 0


def test_a_strong_echo_is_white_and_no_more() -> None:
    facing = sonar([solid("box", (1.0, 200.0, 200.0), (9.5, 0.0, 0.0))], range_m=12.0)

    assert facing.image(HERE, 0).max() == 255


def test_an_image_depends_on_seed_and_frame_alone() -> None:
    one, other = (sonar(seabed_m=5.0, tilt_rad=0.4, noise_seed=8) for _ in range(2))

    first = one.image(HERE, 4)
    second = one.image(HERE, 5)
    assert other.image(HERE, 4).tobytes() == first.tobytes() != second.tobytes()
    seeded = sonar(seabed_m=5.0, tilt_rad=0.4, noise_seed=9)
    assert seeded.image(HERE, 4).tobytes() != first.tobytes()


def test_threads_do_not_change_an_image() -> None:
    looking = [sonar(seabed_m=5.0, tilt_rad=0.4) for _ in range(4)]
    alone = looking[0].image(HERE, 1).tobytes()

    with ThreadPoolExecutor(4) as pool:
        images = list(pool.map(_three, looking))

    assert {image for three in images for image in three[::2]} == {alone}


def _three(looking: Sonar) -> list[bytes]:
    return [looking.image(HERE, frame).tobytes() for frame in (1, 2, 1)]


@pytest.mark.slow
def test_images_have_the_same_bits_on_the_oldest_processor() -> None:
    here = printed_here(PROGRAM)

    assert len(set(here.split())) == 2
    assert here == printed(PROGRAM, on="oldest")


def test_an_image_allocates_itself_alone() -> None:
    looking = sonar(seabed_m=5.0, tilt_rad=0.4)
    looking.image(HERE, 0)
    tracemalloc.start()
    for frame in range(5):
        looking.image(HERE, frame)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert peak < 3 * BEAMS * BINS


@pytest.mark.parametrize(
    "change",
    [{"range_m": 0.0}, {"range_m": 1e9}, {"bins": 4096}, {"bins": 40}, {"beams": 100_000}],
)
def test_impossible_devices_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="not"):
        Device(**{"range_m": 20.0, "tilt_rad": 0.0} | change)  # type: ignore[arg-type]


def test_the_fan_has_starboard_on_the_right_and_the_far_end_above() -> None:
    image = np.zeros((BINS, BEAMS), np.uint8)
    column = 190
    image[298:303, column - 2 : column + 3] = 255

    fan = to_fan(image, DEVICE, height=400)

    assert fan.shape == fan_shape(400)
    rows, columns = np.nonzero(fan > 200)
    away, azimuth = 300.5, DEVICE.azimuth_rad(column)
    assert 400 - rows.mean() == pytest.approx(away * np.cos(azimuth), abs=2.0)
    assert columns.mean() - fan.shape[1] // 2 == pytest.approx(away * np.sin(azimuth), abs=2.0)
    assert in_colour(image, DEVICE, height=400).shape == (*fan.shape, 3)


def test_the_image_of_another_sonar_has_no_fan() -> None:
    with pytest.raises(ValueError, match="400 x 10"):
        to_fan(np.zeros((400, 10), np.uint8), DEVICE, height=100)
