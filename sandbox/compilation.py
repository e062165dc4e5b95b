"""Compiling an upload: untrusted execution like any other, in a box of its own.

The text goes in through the protocol's socket, the program comes out through the pipe of standard
output: no folder is shared. What comes out is as untrusted as what went in.
"""

from dataclasses import replace
from typing import NoReturn

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.limits import COMPILING, Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, SandboxBroken, Verdict

LAYOUT: dict[str, object] = {"observation": []}  # a compiler gets no observations


def compiled(
    language: str,
    source: bytes,
    filename: str,
    *,
    isolation: IsolationLevel,
    core: int | None = None,
    limits: Limits = COMPILING,
) -> bytes:
    """Return what runs: the compiled program, or the source if the language has no compiler.

    Raises
    ------
    ProgramEnded
        The source cannot be compiled, or not within `limits`.
    SandboxBroken
        The compiler is missing, or its box failed.
    """
    compiler = LANGUAGES[language].compiler
    if compiler is None:
        return source
    with Box(language, limits=limits, isolation=isolation, core=core, runtime=compiler()) as box:
        try:
            box.load(source, filename, {}, LAYOUT)
            program = box.finish().output
        except ProgramEnded as end:
            _refuse(end.outcome, limits)
    if not program:
        raise SandboxBroken("the compiler succeeded without an output")
    return program


def _refuse(outcome: Outcome, limits: Limits) -> NoReturn:
    """Raise the compiler's outcome as the program's: its text is wrong, or exceeds a limit."""
    sentence = outcome.sentence
    if outcome.verdict is Verdict.TIME_LIMIT and not outcome.suspect_host:
        sentence = f"Compiling took more than {limits.cpu_s:g} s of CPU time."
    elif outcome.verdict is Verdict.MEMORY_LIMIT:
        sentence = f"Compiling took more than {limits.memory_mib} MiB of memory."
    elif outcome.verdict is Verdict.OUTPUT_LIMIT:
        sentence = f"The compiled program has more than {limits.output_max_mib} MiB."
    verdict = Verdict.COMPILE_ERROR
    # The output so far is an incomplete binary, nothing to read.
    raise ProgramEnded(replace(outcome, verdict=verdict, sentence=sentence, output=b""))
