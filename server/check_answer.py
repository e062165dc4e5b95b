"""What a check says: its problems with their places, the program's output, its time per step."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from server.causes import WORDS, Cause
from server.flaws import Flaw, Stage

OUTPUT_MAX = 8000  # [character] shown, from the end
FLAWS_MAX = 50
# As runners write it: "... (line 3 of law/pid.py)"
_PLACE = re.compile(r" \((?:\w+ begins in )?line (\d+) of ([^()]+)\)$")
# As compilers write it: "controller.c:3:5: error: ..."
_COMPILER = re.compile(r"^([^\s:]+):(\d+):(?:(\d+):)? (?:fatal )?(error|warning): (.*)$", re.M)
_IN_CALL = re.compile(r"(, in |^|seamark_)(step|reset|start|update|detect)\b", re.M)


@dataclass(slots=True)
class Seen:
    """What was seen of a program while it ran."""

    verdict: str = "ok"  # a cause of `server.causes`, or "ok"
    sentence: str = ""
    traceback: str = ""
    output: str = ""
    t_simulated: float = 0.0  # [s]
    step_us: list[float] = field(default_factory=list)  # wall time of each answer


def of_reading(flaws: Sequence[Flaw]) -> dict[str, Any]:
    """Return the answer for a program that need not be run to see what is wrong."""
    return _document(list(flaws), Seen())


def of_running(seen: Seen, *, step_allowed_us: float) -> dict[str, Any]:
    """Return the answer for a program that was run.

    Parameters
    ----------
    step_allowed_us : float
        CPU time that a whole run has for each step on average.
    """
    flaws = [] if seen.verdict == "ok" else _flaws(seen)
    if not flaws and seen.step_us and float(np.median(seen.step_us)) > step_allowed_us:
        took = float(np.median(seen.step_us)) / 1000
        sentence = (
            f"A step takes {took:.1f} ms; a whole run would be ended by its time limit, which "
            f"leaves {step_allowed_us / 1000:.1f} ms of CPU time for each."
        )
        flaws.append(Flaw(sentence=sentence, stage=Stage.RUN, warning=True))
    return _document(flaws, seen)


def our_failure() -> dict[str, Any]:
    """Return the answer when the service and not the program failed."""
    said = WORDS[Cause.PLATFORM_ERROR]
    return _document([Flaw(sentence=f"{said.title}. {said.sentence}", stage=Stage.RUN)], Seen())


def _document(flaws: list[Flaw], seen: Seen) -> dict[str, Any]:
    steps = np.array(seen.step_us)
    return {
        "ok": all(flaw.warning for flaw in flaws),
        "problems": [flaw.to_json() for flaw in flaws[:FLAWS_MAX]],
        "traceback": seen.traceback,
        "output": seen.output[-OUTPUT_MAX:],
        "t_simulated": seen.t_simulated,
        "step_us": None
        if not len(steps)
        else {
            "count": len(steps),
            "median": float(np.median(steps)),
            "most": float(np.max(steps)),
        },
    }


def _flaws(seen: Seen) -> list[Flaw]:
    """Return what ended the program, with its place; all messages of a compiler."""
    if seen.verdict == Cause.COMPILE_ERROR:
        told = [_of_compiler(match) for match in _COMPILER.finditer(seen.traceback)]
        if told:
            return told
    place = _PLACE.search(seen.sentence)
    sentence = seen.sentence[: place.start()] if place else seen.sentence
    return [
        Flaw(
            sentence=sentence or WORDS[Cause(seen.verdict)].sentence,
            stage=_stage(seen),
            file=place[2] if place else None,
            line=int(place[1]) if place else None,
        )
    ]


def _of_compiler(match: re.Match[str]) -> Flaw:
    file, line, column, kind, sentence = match.groups()
    return Flaw(
        sentence=sentence,
        stage=Stage.COMPILE,
        file=file,
        line=int(line),
        column=int(column) if column else None,
        warning=kind == "warning",
    )


def _stage(seen: Seen) -> Stage:
    if seen.verdict == Cause.COMPILE_ERROR:
        return Stage.COMPILE
    in_call = _IN_CALL.search(f"{seen.sentence}\n{seen.traceback}")
    answered = seen.step_us or seen.verdict == Cause.PROTOCOL_ERROR
    return Stage.RUN if answered or in_call else Stage.START
