"""MATLAB: one file of functions, or an archive with more beside it, run by GNU Octave."""

from seamark.sandbox.languages.language import Calls, Language, Runtime

CALLS = Calls(
    "The program (reading it and controller_setup)", "controller_reset", "controller_step"
)

SELF_TEST = """\
function state = controller_setup(config)
    state.gain = 0.5;
end

function [command, state] = controller_step(state, observation)
    command = [state.gain * observation.error; 0.0];
end

function state = tracker_start(state, image, corners)
    state = corners;
end

function corners = tracker_update(state, image)
    corners = state + double(image(2, 1));
end
"""


def running() -> Runtime:
    """Return what Octave needs in its box."""
    from seamark.sandbox.languages.octave.host import running  # noqa: PLC0415  (looks at the host)

    return running()


MATLAB = Language(
    *("matlab", "MATLAB (by GNU Octave)", (".m",), running, SELF_TEST),
    calls=CALLS,
    packages=("octave",),
    roles=("controller", "tracker", "detector"),
    mains=("controller.m",),
)
