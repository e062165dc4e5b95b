"""What a check says: its problems with their places, the program's output, its time per step."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from seamark.server.programs.diagnostics import Flaw, Stage
from seamark.server.runs.failure_reasons import WORDS, Cause

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

    verdict: str = "ok"  # a cause of `seamark.server.runs.failure_reasons`, or "ok"
    sentence: str = ""
    traceback: str = ""
    output: str = ""
    t_simulated: float = 0.0  # [s]
    step_us: list[float] = field(default_factory=list)  # wall time of each answer
    usage: dict[str, float] = field(default_factory=dict)  # cpu_s, memory_mib: start included


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
    took = _cpu_us(seen)
    if not flaws and took > step_allowed_us:
        sentence = (
            f"A step takes {took / 1000:.1f} ms; a whole run would be ended by its time limit, "
            f"which leaves {step_allowed_us / 1000:.1f} ms of CPU time for each."
        )
        flaws.append(Flaw(sentence=sentence, stage=Stage.RUN, warning=True))
    return _document(flaws, seen)


def _cpu_us(seen: Seen) -> float:
    """Return how much of a core a step takes at most.

    The CPU time holds the program's start, the wall time whatever else the host does: the smaller
    of the two accuses nobody wrongly.
    """
    if not seen.step_us:
        return 0.0
    cpu_us = seen.usage.get("cpu_s", 0.0) * 1e6 / len(seen.step_us)
    return min(cpu_us, float(np.median(seen.step_us)))


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
        "usage": seen.usage or None,
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
