"""MATLAB: one file of functions, or an archive with more beside it, run by GNU Octave."""

from pathlib import Path

from seamark.sandbox.languages.language import (
    ALL_ROLES,
    DETECTOR,
    TRACKER,
    Calls,
    Declarations,
    Language,
)
from seamark.sandbox.languages.sample import Sample, sample
from seamark.sandbox.runtime import Runtime

HERE = Path(__file__).parent


def runtime() -> Runtime:
    """Return what Octave needs in its box."""
    from seamark.sandbox.languages.matlab.host import octave_runtime  # noqa: PLC0415  (lazily)

    return octave_runtime()


MATLAB = Language(
    name="matlab",
    label="MATLAB (by GNU Octave)",
    suffixes=(".m",),
    runtime=runtime,
    calls=Calls(
        "The program (parsing and controller_setup)", "controller_reset", "controller_step"
    ),
    self_test=sample(HERE / "self_test.m"),
    starters=(
        sample(HERE / "starter/controller.m"),
        Sample(files={"controller.m": HERE / "starter/arm_controller.m"}, moves_arm=True),
        sample(HERE / "starter/tracker.m", role=TRACKER),
        sample(HERE / "starter/detector.m", role=DETECTOR),
    ),
    conformance=(
        sample(HERE / "starter/controller.m"),
        sample(HERE / "starter/tracker.m", role=TRACKER),
        sample(HERE / "starter/detector.m", role=DETECTOR),
    ),
    roles=ALL_ROLES,
    debian_packages=("octave",),
    archive_mains=("controller.m", "tracker.m", "detector.m"),
    syntax="matlab",
    declarations=Declarations.COMMENTS,
    in_the_box="GNU Octave without packages and toolboxes.",
)
