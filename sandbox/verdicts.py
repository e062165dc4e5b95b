"""The sentences about how a program ended: one function per way, for the program's owner."""

import signal

from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Failure, Verdict

DISCONNECTED = 70  # exit code of a runner that has lost its connection (languages/*/inside)
SIGNALLED = 128  # exit code of bubblewrap: 128 + signal

BECAUSE = {
    signal.SIGSEGV: "native code accessed invalid memory, or recursed too deeply",
    signal.SIGABRT: "native code aborted (abort, or an uncaught exception)",
    signal.SIGFPE: "native code divided an integer by zero",
    signal.SIGBUS: "a file that was mapped into memory was truncated",
    signal.SIGSYS: "it made a system call of another architecture",
    signal.SIGILL: "a library uses instructions that this processor does not have",
    signal.SIGXFSZ: "it wrote a file beyond the limit",
}


def cpu_limit(limits: Limits, used_s: float) -> Failure:
    """Return that the CPU time of the whole run is used up."""
    sentence = f"The program used {used_s:.1f} s of CPU time; the limit is {limits.cpu_s:g} s."
    return Failure(Verdict.TIME_LIMIT, sentence)


def answer_cpu_limit(waited_for: str, cpu_s: float) -> Failure:
    """Return that one answer took too much CPU time."""
    sentence = f"{waited_for} used {cpu_s:g} s of CPU time and did not return."
    return Failure(Verdict.TIME_LIMIT, sentence)


def answer_wall_limit(waited_for: str, wall_s: float) -> Failure:
    """Return that an answer did not come in time."""
    sentence = f"{waited_for} did not return within {wall_s:g} s."
    return Failure(Verdict.TIME_LIMIT, sentence)


def wall_limit(limits: Limits) -> Failure:
    """Return that the whole run took too long."""
    sentence = f"The program took more than {limits.wall_s:g} s for all its answers together."
    return Failure(Verdict.TIME_LIMIT, sentence)


def memory_limit(limits: Limits) -> Failure:
    """Return that the program exceeded its memory."""
    sentence = f"The program used more than {limits.memory_mib} MiB of memory."
    return Failure(Verdict.MEMORY_LIMIT, sentence)


def output_limit(limits: Limits) -> Failure:
    """Return that the program printed too much."""
    sentence = f"The program printed more than {limits.output_max_mib} MiB."
    return Failure(Verdict.OUTPUT_LIMIT, sentence)


def process_limit(limits: Limits, trace: str = "") -> Failure:
    """Return that the program failed after it was refused another process."""
    sentence = f"The program tried to start more than {limits.processes} processes and threads."
    return Failure(Verdict.PROCESS_LIMIT, sentence, trace)


def protocol_error(sentence: str) -> Failure:
    """Return that the program violated the protocol."""
    return Failure(Verdict.PROTOCOL_ERROR, sentence)


def still_running() -> Failure:
    """Return that the program closed its connection without exiting."""
    return protocol_error("The program closed its connection to the simulator and kept running.")


def died(exit_code: int) -> Failure:
    """Return that the process exited by itself or was ended by a signal."""
    if exit_code == DISCONNECTED:
        return protocol_error("The program closed its connection to the simulator.")
    number = exit_code - SIGNALLED
    if number not in set(signal.Signals):
        sentence = f"The program exited (exit code {exit_code}) before the run was over."
        return Failure(Verdict.USER_ERROR, sentence)
    name = signal.Signals(number)
    because = f": {BECAUSE[name]}" if name in BECAUSE else ""
    return Failure(Verdict.USER_ERROR, f"The program was ended by {name.name}{because}.")
