"""A user's picture on the target: what of it is shown, and the file in which a run has it."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from seamark.sim.benchmarks.visibility_v2.scenario import draw_scenario
from seamark.sim.camera import pictures
from seamark.sim.files import picture_conversion, target_pictures
from seamark.sim.files.library import FileInvalid
from seamark.sim.files.target_pictures import HEIGHT, LIBRARY, WIDTH
from seamark.sim.recording.manifest import manifest
from seamark.sim.registry import benchmark
from seamark.sim.settings import own_files
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import MARKER

KEPT = LIBRARY.converted(MARKER)
GREY = target_pictures.read(KEPT)


def encoded(image: Any, suffix: str = ".png") -> bytes:
    return cv2.imencode(suffix, image)[1].tobytes()


def stripes(rows: int, columns: int) -> np.ndarray:
    """Return a picture in colours with stripes, each 10 px wide."""
    grey = np.where(np.arange(columns) // 10 % 2, 220, 30).astype(np.uint8)
    return np.repeat(np.tile(grey, (rows, 1))[:, :, None], 3, axis=2)


@given(arrays.arrays(np.uint8, (HEIGHT, WIDTH), elements=st.sampled_from([0, 90, 255])))
def test_grey_levels_are_read_as_they_were_written(grey: Any) -> None:
    grey[0] = 255
    grey[1:20] = 0  # contrast
    content = target_pictures.write(grey)

    assert np.array_equal(target_pictures.read(content), grey)
    assert max(map(len, content.splitlines())) <= 70
    assert LIBRARY.converted(content) == content


def test_other_programs_read_the_file_as_we_do() -> None:
    decoded = cv2.imdecode(np.frombuffer(KEPT, np.uint8), cv2.IMREAD_GRAYSCALE)

    assert np.array_equal(decoded, GREY)


@pytest.mark.parametrize(
    ("rows", "columns"), [(HEIGHT, WIDTH), (3 * HEIGHT, 900), (124, 3000), (62, 200), (997, 1009)]
)
def test_the_largest_middle_part_is_shown(rows: int, columns: int) -> None:
    """A frame of white around that part leaves no trace; each pixel is a mean over its area."""
    width, height = min(columns, rows * WIDTH // HEIGHT), min(rows, columns * HEIGHT // WIDTH)
    row, column = (rows - height) // 2, (columns - width) // 2
    image = np.full((rows, columns, 3), 255, np.uint8)
    image[row : row + height, column : column + width] = stripes(height, width) // 2
    shown = target_pictures.read(LIBRARY.converted(encoded(image)))
    part = image[row : row + height, column : column + width, 0].astype(float)
    area = cv2.resize(part, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)

    assert shown.max() < 128
    assert shown.mean() == pytest.approx(part.mean(), abs=0.5)
    if height >= HEIGHT:  # to enlarge, OpenCV interpolates
        assert np.abs(area - shown).max() <= 1.0


def test_each_colour_counts_as_the_eye_sees_it() -> None:
    colours = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    for channel in range(3):
        colours[:, channel * 130 : (channel + 1) * 130, channel] = 255  # blue, green, red
    shown = target_pictures.read(LIBRARY.converted(encoded(colours)))

    seen = [int(shown[60, at]) for at in (60, 190, 320)]

    assert seen == pytest.approx([29, 150, 76], abs=1)  # ITU-R BT.601


def test_a_picture_is_the_same_file_from_png_and_pgm() -> None:
    image = np.frombuffer(MARKER[-500 * 160 :], np.uint8).reshape(160, 500)

    assert LIBRARY.converted(encoded(image)) == LIBRARY.converted(encoded(image, ".pgm")) == KEPT


HOSTILE: dict[str, tuple[Callable[[], bytes], str]] = {
    "nothing": (lambda: b"", "can be decoded"),
    "text": (lambda: b"grey " * 1000, "can be decoded"),
    "half of one": (lambda: encoded(stripes(300, 900))[:40], "can be decoded"),
    "too many bytes": (lambda: bytes(LIBRARY.bytes_max + 1), "at most 4 MiB"),
    "too wide": (lambda: encoded(stripes(100, 5000)), "at most 4096 px"),
    "too small": (lambda: encoded(stripes(61, 300)), "at least 200 x 62"),
    "too narrow": (lambda: encoded(stripes(900, 199)), "at least 200 x 62"),
    "one grey": (lambda: encoded(np.full((200, 600), 90, np.uint8)), "next to no contrast"),
    "a number too few": (lambda: KEPT.rstrip().rpartition(b" ")[0], "must have 49600 numbers"),
    "a number too many": (lambda: KEPT + b"1\n", "must have 49600 numbers"),
    "a negative number": (lambda: KEPT.rstrip()[:-2] + b"-1\n", "must have 49600 numbers"),
    "too bright": (lambda: KEPT.rstrip().rpartition(b" ")[0] + b" 256\n", "at most 255"),
    "long numbers": (lambda: KEPT[:20] + b"0" * 150_000 + KEPT[20:], "not a plain PGM"),
}


@pytest.mark.parametrize("attack", HOSTILE)
def test_what_is_no_picture_for_a_target_is_refused_with_the_reason(attack: str) -> None:
    make, sentence = HOSTILE[attack]

    with pytest.raises(FileInvalid, match=re.escape(sentence)):
        LIBRARY.converted(make())


def test_a_picture_of_just_enough_contrast_and_size_is_taken() -> None:
    image = np.full((62, 200), 100, np.uint8)
    image[:, ::2] += 17
    image[:, 1::2] -= 1  # standard deviation of 9

    assert LIBRARY.converted(encoded(image))


def test_the_top_of_the_target_shows_the_picture_and_its_sides_go_on_mirrored() -> None:
    with LIBRARY.lending(KEPT) as name:
        cutout = pictures.cutout(name, 0.3, 0.9)
        tile, top = pictures.tile(name), pictures.face(cutout, 200, 62, number=0)
        below = pictures.face(cutout, 200, 62, number=1)
    rows = slice(cutout.row, cutout.row + HEIGHT)
    columns = slice(cutout.column, cutout.column + WIDTH)
    halved = GREY.reshape(62, 2, 200, 2).mean(axis=(1, 3))

    assert np.array_equal(tile[rows, columns], GREY)
    assert np.array_equal(tile[rows.stop, columns], GREY[-1])
    assert np.corrcoef(top.ravel(), halved.ravel())[0, 1] > 0.95  # smoothed over three texels
    assert 255.0 * top.mean() == pytest.approx(pictures.MEAN, abs=6.0)
    assert abs(np.corrcoef(top.ravel(), below.ravel())[0, 1]) < 0.9


@pytest.mark.parametrize("version", ["visibility-v2", "visibility-v3"])
def test_a_file_is_a_value_of_the_setting_and_stands_in_the_manifest(
    tmp_path: Path, version: str
) -> None:
    file = tmp_path / "Marker.PGM"
    file.write_bytes(MARKER)
    config: Any = benchmark(version).read(own_files.resolved({"target_texture": file}))
    facts: Any = {"seed": 1, "trials": 1, "controller": "x", "program_sha256": None, "digest": ""}
    document = manifest(version, config, **facts)

    assert config.target_texture == LIBRARY.name_of(KEPT)
    assert document["target_file"]["text"].encode() == KEPT
    assert document["target_file"]["sha256"].startswith(config.target_texture.partition("@")[2])
    plain: Any = benchmark(version).read({})
    assert "target_file" not in manifest(version, plain, **facts)


def test_every_trial_shows_a_users_picture_and_any_other_picture_differs() -> None:
    with LIBRARY.lending(KEPT) as name:
        config: Any = benchmark("visibility-v2").read({"target_texture": name})
        own = [draw_scenario(config, 5, trial) for trial in range(3)]
        views = [one.camera(0.0, 1.27).grey(one.station, 0) for one in own]
    bricks: Any = benchmark("visibility-v2").read({"target_texture": "brick"})
    other = draw_scenario(bricks, 5, 0)

    assert {one.texture for one in own} == {name}
    assert other.station == own[0].station
    assert not np.array_equal(other.camera(0.0, 1.27).grey(other.station, 0), views[0])


def test_a_picture_that_is_not_known_is_refused_with_where_one_can_be_used() -> None:
    for value in (LIBRARY.name_of(b"another"), "logo.png"):
        with pytest.raises(ConfigurationInvalid, match=r"target_texture=FILE\.png"):
            benchmark("visibility-v3").read({"target_texture": value})


def test_the_file_that_a_user_has_is_named_where_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(b"no picture")
    for name, sentence in (("a.png", "can be decoded"), ("b.png", "cannot be read: No such file")):
        with pytest.raises(FileInvalid, match=sentence) as caught:
            own_files.resolved({"target_texture": tmp_path / name})
        assert str(caught.value).startswith(f"{tmp_path / name}: ")


@given(st.integers(1, 60), st.integers(1, 60), st.integers(1, 60), st.data())
def test_areas_are_summed_exactly(rows: int, columns: int, count: int, data: Any) -> None:
    shape, elements = (rows, columns), st.integers(0, 255_000)
    values = data.draw(arrays.arrays(np.int64, shape, elements=elements))
    repeated = np.repeat(values, count, axis=0).reshape(count, rows, columns)

    assert np.array_equal(picture_conversion._summed(values, count), repeated.sum(axis=1))
