"""Whether this host can run a language: its self-test program must answer one step right."""

from sandbox.box import Box
from sandbox.compilation import compiled
from sandbox.languages import LANGUAGES
from sandbox.level import Level
from sandbox.limits import Limits
from sandbox.outcome import ProgramEnded, SandboxBroken

LIMITS = Limits(cpu_s=10.0, wall_s=20.0, memory_mib=192, processes=12)
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
OBSERVATION = (0.0, 1.0, -2.0, 3.0)
COMMAND = (0.5, -1.0, 1.5, 0.0)  # half the error


def why_not(language: str, level: Level) -> str:
    """Return why programs in this language cannot be run here; empty if they can."""
    known = LANGUAGES[language]
    name = f"self_test{known.suffixes[0]}"
    try:
        test = known.self_test
        source = test.encode() if isinstance(test, str) else test()
        program = compiled(known.tested_by or language, source, name, level=level)
        with Box(language, limits=LIMITS, level=level) as box:
            box.load(program, name, {}, LAYOUT)
            answer = box.step(OBSERVATION)
            box.finish()
    except (SandboxBroken, ProgramEnded) as error:
        return str(error)
    return "" if answer == COMMAND else f"the self-test answered {answer}, not {COMMAND}"
