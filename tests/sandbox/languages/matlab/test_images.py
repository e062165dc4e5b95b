"""Trackers and detectors in MATLAB: they see the images; what they return is checked."""

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.protocol.answers import Detection, Loss
from tests.sandbox.host_compiler import zipped
from tests.services.languages import skip_without

pytestmark = pytest.mark.host

CORNERS = np.array([[10.0, 20.0], [30.5, 20.0], [30.5, 40.0], [10.0, 40.0]])
TRACKER = b"""
function state = tracker_setup(config)
    state.gain = config.gain;
end

function state = tracker_start(state, image, corners)
    state.first = image;
    state.corners = corners;
end

function [corners, state] = tracker_update(state, image)
    weights = reshape(mod(0:numel(image) - 1, 251) + 1, size(image));
    digest = sum((double(image) .* weights)(:));
    printf("%s %s %d\\n", class(image), mat2str(size(image)), digest);
    corners = state.corners + state.gain * double(state.first(1, 2));
    if image(1, 1) == 255
        corners = [];
    end
end
"""
DETECTOR = """
function found = detector_detect(state, image)
    one.label = "box";
    one.corners = [1 2; 3 2; 3 4; 1 4];
    one.confidence = 0.5;
    found = %s;
end
"""


@pytest.fixture(scope="module")
def octave(isolation: IsolationLevel) -> IsolationLevel:
    skip_without("matlab", isolation)
    return isolation


def image_of(shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(7).integers(0, 250, shape, np.uint8)


def printed_for(image: np.ndarray) -> str:
    """Return what TRACKER prints of an image, in Octave's memory order."""
    weights = (np.arange(image.size) % 251 + 1).reshape(image.shape, order="F")
    size = " ".join(map(str, image.shape))
    return f"uint8 [{size}] {(image.astype(np.int64) * weights).sum()}"


@pytest.mark.parametrize("shape", [(240, 320), (33, 57, 3), (1, 2)])
def test_a_tracker_sees_each_image_and_returns_corners(shape, octave) -> None:
    first, second, last = image_of(shape), image_of(shape) // 2, image_of(shape)
    last[0, 0] = 255
    with Box("matlab", limits=Limits(), isolation=octave) as box:
        box.load(TRACKER, "mine.m", {"gain": 0.5}, {"role": "tracker"})
        box.start(first, CORNERS)
        seen, lost = box.update(second), box.update(last)
        box.start(second, CORNERS + 1.0)  # a level later
        again = box.update(first)
        output = box.finish().output.decode().splitlines()

    assert np.array_equal(np.array(seen), CORNERS + 0.5 * float(first[0, 1].flat[0]))
    assert np.array_equal(np.array(again), CORNERS + 1.0 + 0.5 * float(second[0, 1].flat[0]))
    assert lost is Loss.REPORTED
    assert output == [printed_for(second), printed_for(last), printed_for(first)]


@pytest.mark.parametrize("number", ["NaN", "Inf", "-1e7"])
def test_corners_out_of_range_are_a_loss(number, octave) -> None:
    source = TRACKER.replace(b"corners = [];", f"corners(2, 1) = {number};".encode())
    last = image_of((33, 57))
    last[0, 0] = 255
    with Box("matlab", limits=Limits(), isolation=octave) as box:
        box.load(source, "mine.m", {"gain": 0.5}, {"role": "tracker"})
        box.start(image_of((33, 57)), CORNERS)
        wild, good = box.update(last), box.update(image_of((33, 57)))
        box.finish()

    assert wild is Loss.OUT_OF_RANGE
    assert not isinstance(good, Loss)


def test_a_detector_returns_detections_with_labels(octave) -> None:
    expected = Detection("box", ((1.0, 2.0), (3.0, 2.0), (3.0, 4.0), (1.0, 4.0)), 0.5)
    with Box("matlab", limits=Limits(), isolation=octave) as box:
        box.load((DETECTOR % "[one, one]").encode(), "d.m", {}, {"role": "detector"})
        assert box.detect(image_of((24, 32))) == [expected, expected]
        assert box.finish().verdict is Verdict.OK


def test_the_main_file_of_an_archive_is_named_after_the_role(octave) -> None:
    main = (DETECTOR % "helper(one)").encode()
    archive = zipped({"detector.m": main, "helper.m": b"function y = helper(x)\n y = x;\nend\n"})
    with Box("matlab", limits=Limits(), isolation=octave) as box:
        box.load(archive, "d.zip", {}, {"role": "detector"})

        assert [one.label for one in box.detect(image_of((24, 32)))] == ["box"]


def ended(source: str, octave: IsolationLevel, role: str) -> Outcome:
    """Return how a tracker or detector ends after two images."""
    with Box("matlab", limits=Limits(), isolation=octave) as box:
        try:
            box.load(source.encode(), "mine.m", {}, {"role": role})
            if role == "detector":
                box.detect(image_of((24, 32)))
            else:
                box.start(image_of((24, 32)), CORNERS)
                box.update(image_of((24, 32)))
            return box.finish()
        except ProgramEnded as end:
            return end.outcome


@pytest.mark.parametrize(
    ("returned", "says"),
    [
        ("{1}", "an array of at most 64 structures"),
        ("repmat(one, 1, 65)", "at most 64"),
        ("setfield(one, 'confidence', NaN)", "confidence"),
        ("setfield(one, 'label', '')", "label"),
        ("setfield(one, 'label', repmat('a', 1, 65))", "label"),
        ("setfield(one, 'corners', [1 2])", r"size \[1 2\]"),
    ],
)
def test_an_invalid_detection_is_explained(returned, says, octave) -> None:
    outcome = ended(DETECTOR % returned, octave, "detector")

    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert says.replace("\\", "") in outcome.sentence


def test_a_tracker_without_its_functions_is_told_which_are_missing(octave) -> None:
    outcome = ended("function state = tracker_start(state, image, corners)\nend", octave, "tracker")

    assert outcome.verdict is Verdict.USER_ERROR
    assert "mine.m does not define tracker_update. A tracker has the functions" in outcome.sentence


def test_an_error_of_a_tracker_comes_with_its_line(octave) -> None:
    text = "function c = tracker_update(s, image)\n c = 1;\n nothing_like_this(1);\nend\n"
    start = "function s = tracker_start(s, image, corners)\nend\n"

    outcome = ended(text + start, octave, "tracker")

    assert outcome.verdict is Verdict.USER_ERROR
    assert "line 3 of mine.m" in outcome.sentence
