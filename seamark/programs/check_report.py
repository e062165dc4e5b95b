"""The report of a check: diagnostics with their locations, the output, the time per step."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from seamark.programs.diagnostics import Diagnostic, Stage
from seamark.programs.failure_hints import hint
from seamark.programs.failure_reasons import DESCRIPTIONS, FailureReason
from seamark.sandbox.printable_text import printable_text

OUTPUT_MAX = 8000  # [character] of the output, from its end
DIAGNOSTICS_MAX = 50
# As the runners write it: "... (line 3 of law/pid.py)"
_LOCATION = re.compile(r" \((?:\w+ begins in )?line (\d+) of ([^()]+)\)$")
# As compilers write it: "controller.c:3:5: error: ..."
_COMPILER_MESSAGE = re.compile(
    r"^([^\s:]+):(\d+):(?:(\d+):)? (?:fatal )?(error|warning): (.*)$", re.MULTILINE
)
_IN_CALL = re.compile(r"(, in |^|seamark_)(step|reset|start|update|detect)\b", re.MULTILINE)


@dataclass(slots=True)
class CheckOutcome:
    """What was observed of a program while it ran."""

    verdict: str = "ok"  # a cause of `seamark.programs.failure_reasons`, or "ok"
    sentence: str = ""
    traceback: str = ""
    output: str = ""
    t_simulated: float = 0.0  # [s]
    step_us: list[float] = field(default_factory=list)  # wall time of each step
    usage: dict[str, float] = field(default_factory=dict)  # cpu_s, memory_mib; includes the start


def from_diagnostics(diagnostics: Sequence[Diagnostic]) -> dict[str, Any]:
    """Return the report of a program that was only read."""
    return _document(diagnostics, CheckOutcome())


def from_outcome(outcome: CheckOutcome, *, step_allowed_us: float) -> dict[str, Any]:
    """Return the report of a program that was run.

    Parameters
    ----------
    step_allowed_us : float
        Average CPU time [µs] per step within the limits of a whole run.
    """
    diagnostics = [] if outcome.verdict == "ok" else _from_failure(outcome)
    step_us = _cpu_us_per_step(outcome)
    if not diagnostics and step_us > step_allowed_us:
        sentence = (
            f"A step takes {step_us / 1000:.1f} ms. A whole run would exceed its time limit, "
            f"which allows {step_allowed_us / 1000:.1f} ms of CPU time per step."
        )
        diagnostics.append(Diagnostic(sentence=sentence, stage=Stage.RUN, warning=True))
    return _document(diagnostics, outcome)


def platform_failure() -> dict[str, Any]:
    """Return the report for a failure of the service rather than of the program."""
    reason = DESCRIPTIONS[FailureReason.PLATFORM_ERROR]
    sentence = f"{reason.title}. {reason.sentence}"
    return _document([Diagnostic(sentence=sentence, stage=Stage.RUN)], CheckOutcome())


def _cpu_us_per_step(outcome: CheckOutcome) -> float:
    """Return an upper bound of the CPU time [µs] per step.

    The CPU time includes the start of the program, the wall time whatever else the host does; the
    smaller of the two avoids false warnings.
    """
    if not outcome.step_us:
        return 0.0
    cpu_us = outcome.usage.get("cpu_s", 0.0) * 1e6 / len(outcome.step_us)
    return min(cpu_us, float(np.median(outcome.step_us)))


def _document(diagnostics: Sequence[Diagnostic], outcome: CheckOutcome) -> dict[str, Any]:
    steps = np.array(outcome.step_us)
    return {
        "ok": all(diagnostic.warning for diagnostic in diagnostics),
        "problems": [diagnostic.to_json() for diagnostic in diagnostics[:DIAGNOSTICS_MAX]],
        "traceback": printable_text(outcome.traceback),
        "output": printable_text(outcome.output[-OUTPUT_MAX:]),
        "t_simulated": outcome.t_simulated,
        "usage": outcome.usage or None,
        "step_us": None
        if not len(steps)
        else {
            "count": len(steps),
            "median": float(np.median(steps)),
            "most": float(np.max(steps)),
        },
    }


def _from_failure(outcome: CheckOutcome) -> list[Diagnostic]:
    """Return all messages of the compiler, or else what ended the program and where."""
    if outcome.verdict == FailureReason.COMPILE_ERROR:
        messages = _COMPILER_MESSAGE.finditer(outcome.traceback)
        if diagnostics := [_from_compiler(match) for match in messages]:
            return diagnostics
    location = _LOCATION.search(outcome.sentence)
    sentence = outcome.sentence[: location.start()] if location else outcome.sentence
    sentence = sentence or DESCRIPTIONS[FailureReason(outcome.verdict)].sentence
    remedy = hint(outcome.sentence).remedy
    return [
        Diagnostic(
            sentence=f"{sentence.rstrip('.')}. {remedy}" if remedy else sentence,
            stage=_stage(outcome),
            file=location[2] if location else None,
            line=int(location[1]) if location else None,
        )
    ]


def _from_compiler(match: re.Match[str]) -> Diagnostic:
    file, line, column, severity, sentence = match.groups()
    return Diagnostic(
        sentence=sentence,
        stage=Stage.COMPILE,
        file=file,
        line=int(line),
        column=int(column) if column else None,
        warning=severity == "warning",
    )


def _stage(outcome: CheckOutcome) -> Stage:
    if outcome.verdict == FailureReason.COMPILE_ERROR:
        return Stage.COMPILE
    in_call = _IN_CALL.search(f"{outcome.sentence}\n{outcome.traceback}")
    answered = outcome.step_us or outcome.verdict == FailureReason.PROTOCOL_ERROR
    return Stage.RUN if answered or in_call else Stage.START
