"""Trackers and detectors in C: they see the images that went in, and cannot change them."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict
from seamark.sandbox.protocol.answers import Loss
from tests.services.languages import skip_without

pytestmark = pytest.mark.host

CORNERS = np.array([[10.0, 20.0], [30.5, 20.0], [30.5, 40.0], [10.0, 40.0]])
LIMITS = Limits(cpu_s=5.0, memory_mib=128)
# One program for all: what it does is in the configuration.
PROGRAM = r"""
#include "seamark.h"
#include <dirent.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

static seamark_image first, before;
static int updates;

static double digest(const seamark_image *image) {
    unsigned long sum = 0, size = (unsigned long)image->width * image->height * image->channels;
    if (!image->pixels) return -1.0;
    for (unsigned long i = 0; i < size; i++) sum += image->pixels[i] * (i % 251 + 1);
    return (double)(sum % 9973);
}

static int wants(const char *what) { return seamark_config_number(what, 0.0) != 0.0; }

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    if (wants("refuses")) return 7;
    first = *image;
    printf("%g %g\n", corners[2], corners[7]);
    return 0;
}

static void attack(const seamark_image *image) {
    unsigned char *pixels = (unsigned char *)image->pixels;
    if (wants("writes")) pixels[0]++;
    if (wants("protects") && !mprotect((void *)((unsigned long)pixels & ~4095UL), 4096, 3))
        printf("GOT write access\n");
    if (wants("opens")) {
        char path[300];
        DIR *own = opendir("/proc/self/fd");
        if (own) printf("GOT a list of descriptors\n");
        for (int i = 3; i < 64; i++) {
            snprintf(path, sizeof path, "/proc/self/fd/%d", i);
            if (open(path, O_RDWR) >= 0) printf("GOT descriptor %d again\n", i);
            if (mmap(0, 4096, 3, MAP_SHARED, i, 0) != MAP_FAILED) printf("GOT a mapping\n");
        }
    }
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    if (wants("loses")) return 0;
    if (wants("fails")) return -3;
    attack(image);
    if ((wants("first_nan") || wants("first_huge")) && !updates++) {
        corners[5] = wants("first_nan") ? NAN : -1e300;
        return 1;
    }
    if (wants("moves")) { corners[0] += 1.0; return 1; }
    corners[0] = digest(image), corners[1] = digest(&first), corners[2] = digest(&before);
    corners[3] = image->width, corners[4] = image->height, corners[5] = image->channels;
    corners[6] = corners[7] = 0.0;
    before = *image;
    return 1;
}

int seamark_detect(const seamark_image *image, seamark_detection found[SEAMARK_MOST_DETECTIONS]) {
    int count = (int)seamark_config_number("count", 0.0);
    for (int i = 0; i < count && i < SEAMARK_MOST_DETECTIONS; i++) {
        found[i].corners[i % 8] = digest(image);
        found[i].confidence = seamark_config_number("confidence", 0.5);
        memset(found[i].label, 'a', (size_t)seamark_config_number("letters", 2.0));
    }
    return count;
}
"""

Started = Callable[..., Box]


@pytest.fixture(scope="module")
def program(isolation: IsolationLevel) -> bytes:
    skip_without("c", isolation)
    return compiled("c", PROGRAM.encode(), "mine.c", isolation=isolation)


@pytest.fixture
def started(program: bytes, isolation: IsolationLevel):
    """Return a function that returns a box with the program in it."""
    boxes = []

    def start(role: str = "tracker", **config: float) -> Box:
        box = Box("c", limits=LIMITS, isolation=isolation)
        boxes.append(box)
        box.load(program, "mine.c", config, {"role": role})
        if role == "tracker":
            box.start(picture(seed=0), CORNERS)
        return box

    yield start
    for box in boxes:
        box.close()


def picture(shape: tuple[int, ...] = (240, 320), seed: int = 1) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def digest(image: NDArray[np.uint8]) -> float:
    weights = np.arange(image.size, dtype=np.int64) % 251 + 1
    return float((image.ravel() * weights).sum() % 9973)


def test_a_tracker_sees_the_images_of_the_start_and_of_the_previous_update(started) -> None:
    box = started()
    shapes = [(240, 320), (480, 640, 3), (1, 1), (3, 5)]
    images = [picture(shape, seed) for seed, shape in enumerate(shapes, 1)]
    before = -1.0

    for image in images:
        (x0, y0), (x1, y1), (x2, y2), _ = box.update(image)
        channels = image.shape[2] if image.ndim == 3 else 1
        assert (x0, y0, x1) == (digest(image), digest(picture(seed=0)), before)
        assert (y1, x2, y2) == (image.shape[1], image.shape[0], channels)
        before = digest(image)

    assert box.finish().output == b"30.5 40\n"


def test_corners_start_at_the_targets_last_position(started) -> None:
    box = started(moves=1)

    answers = [box.update(picture()) for _ in range(3)]

    assert [answer[0][0] for answer in answers] == [11.0, 12.0, 13.0]
    assert {answer[1:] for answer in answers} == {tuple(map(tuple, CORNERS[1:].tolist()))}


def test_a_lost_target_has_no_corners(started) -> None:
    assert started(loses=1).update(picture()) is Loss.REPORTED


@pytest.mark.parametrize("wild", ["nan", "huge"])
def test_wild_corners_are_a_loss_and_the_next_search_starts_at_the_last_good_ones(
    wild, started
) -> None:
    box = started(moves=1, **{f"first_{wild}": 1})

    answers = [box.update(picture()) for _ in range(3)]

    assert answers[0] is Loss.OUT_OF_RANGE
    assert [answer[0][0] for answer in answers[1:]] == [11.0, 12.0]


@pytest.mark.parametrize("count", [0, 3, 64])
def test_a_detector_returns_what_it_found(count, started) -> None:
    found = started("detector", count=count).detect(picture())

    assert [one.label for one in found] == ["aa"] * count
    assert [one.corners[i % 8 // 2][i % 2] for i, one in enumerate(found)] == [
        digest(picture())
    ] * count


@pytest.mark.parametrize(
    ("config", "verdict", "says"),
    [
        ({"refuses": 1}, Verdict.USER_ERROR, "seamark_tracker_start returned 7"),
        ({"fails": 1}, Verdict.USER_ERROR, "seamark_tracker_update returned -3"),
        ({"writes": 1}, Verdict.USER_ERROR, "SIGSEGV"),
    ],
)
def test_a_faulty_tracker_ends_with_the_reason(config, verdict, says, started) -> None:
    with pytest.raises(ProgramEnded, match=says) as end:
        started(**config).update(picture())

    assert end.value.outcome.verdict is verdict


@pytest.mark.parametrize(
    ("config", "says"),
    [
        ({"count": -1}, "seamark_detect returned -1"),
        ({"count": 65}, "64 detections"),
        ({"count": 1, "letters": 0}, "label"),
        ({"count": 1, "letters": 65}, "label"),
        ({"count": 1, "confidence": 1.5}, "confidence"),
    ],
)
def test_a_faulty_detector_ends_with_the_reason(config, says, started) -> None:
    with pytest.raises(ProgramEnded, match=says):
        started("detector", **config).detect(picture())


def test_an_attack_on_the_images_memory_achieves_nothing(started) -> None:
    image = picture()
    box = started(protects=1, opens=1)

    for _ in range(3):
        assert box.update(image)[0][0] == digest(image)

    assert b"GOT" not in box.finish().output


def test_a_program_of_another_role_is_told_what_it_needs(isolation, program) -> None:
    layout = {"observation": [["t", 0]]}
    with Box("c", limits=LIMITS, isolation=isolation) as box, pytest.raises(ProgramEnded) as end:
        box.load(program, "mine.c", {}, layout)

    assert end.value.outcome.verdict is Verdict.COMPILE_ERROR
    assert "mine.c does not define seamark_step: a controller" in end.value.outcome.sentence
