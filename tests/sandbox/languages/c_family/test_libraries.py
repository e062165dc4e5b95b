"""Programs in C++ with the optional libraries of the host: OpenCV and Eigen."""

import os

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.c_family.host import cpp_libraries
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict

pytestmark = pytest.mark.host

needs_opencv = pytest.mark.skipif(
    "-lopencv_imgproc" not in cpp_libraries(), reason="libopencv-imgproc-dev is not installed"
)
needs_eigen = pytest.mark.skipif(
    not any("eigen" in option for option in cpp_libraries()), reason="no libeigen3-dev"
)
TRACKER = r"""
#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include "seamark.h"

static cv::Mat seen;

static cv::Mat as_mat(const seamark_image *image) {
    return cv::Mat(image->height, image->width, CV_8U, const_cast<unsigned char *>(image->pixels));
}

int seamark_tracker_start(const seamark_image *image, const double corners[8]) {
    const cv::Rect box(cv::Point(corners[0], corners[1]), cv::Point(corners[4], corners[5]));
    seen = as_mat(image)(box).clone();
    std::printf("%d thread\n", cv::getNumThreads());
    return 0;
}

int seamark_tracker_update(const seamark_image *image, double corners[8]) {
    cv::Mat found;
    cv::Point best;
    cv::matchTemplate(as_mat(image), seen, found, cv::TM_CCOEFF_NORMED);
    cv::minMaxLoc(found, nullptr, nullptr, nullptr, &best);
    const double dx = best.x - corners[0], dy = best.y - corners[1];
    for (int i = 0; i < 8; i++) corners[i] += i % 2 ? dy : dx;
    return 1;
}
"""
REGULATOR = r"""
#include <Eigen/Dense>
#include "seamark.h"

int seamark_step(const seamark_observation *observation, seamark_command *command) {
    Eigen::Matrix2d a;
    a << 2.0, 1.0, 1.0, 3.0;
    const Eigen::Vector2d solved = a.ldlt().solve(Eigen::Vector2d(observation->error));
    command->surge = solved(0), command->sway = solved(1);
    return 0;
}
"""
LAYOUT = {"observation": [["error", 3]], "command": ["surge", "sway", "heave", "yaw_rate"]}


@needs_opencv
def test_a_tracker_in_cpp_follows_its_target_with_opencv(isolation: IsolationLevel) -> None:
    image = np.random.default_rng(5).integers(0, 256, (120, 160), np.uint8)
    corners = np.array([[40.0, 30.0], [80.0, 30.0], [80.0, 60.0], [40.0, 60.0]])
    program = compiled("c++", TRACKER.encode(), "mine.cpp", isolation=isolation)

    core = min(os.sched_getaffinity(0))  # as for a run: the library starts a thread for each
    with Box("c++", limits=Limits(), isolation=isolation, core=core) as box:
        box.load(program, "mine.cpp", {}, {"role": "tracker"})
        box.start(image, corners)
        answer = box.update(np.ascontiguousarray(np.roll(image, (-4, 7), (0, 1))))
        outcome = box.finish()

    assert np.array_equal(answer, corners + np.array([7, -4]))
    assert outcome.output == b"1 thread\n"


@needs_eigen
def test_a_controller_in_cpp_solves_equations_with_eigen(isolation: IsolationLevel) -> None:
    program = compiled("c++", REGULATOR.encode(), "mine.cpp", isolation=isolation)

    with Box("c++", limits=Limits(), isolation=isolation) as box:
        box.load(program, "mine.cpp", {}, LAYOUT)
        answer = box.step([5.0, 5.0, 0.0])

    assert answer == pytest.approx((2.0, 1.0, 0.0, 0.0))


def test_an_absent_header_is_named_with_its_line(isolation: IsolationLevel) -> None:
    source = b'#include "seamark.h"\n#include <torch/script.h>\n'

    with pytest.raises(ProgramEnded) as end:
        compiled("c++", source, "mine.cpp", isolation=isolation)

    assert end.value.outcome.verdict is Verdict.COMPILE_ERROR
    assert end.value.outcome.sentence.startswith("mine.cpp:2:10: fatal error: torch/script.h")
