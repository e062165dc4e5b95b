"""What is said about a program's end: one sentence for each way, with what to do."""

import signal

from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Verdict
from seamark.sandbox.protocol.messages import Failure

DISCONNECTED = 70  # exit code of the runner when it can no longer speak (languages/*_runner)
SIGNALLED = 128  # exit code of bubblewrap: 128 + signal

BECAUSE = {
    signal.SIGSEGV: "native code used memory that is not its own, or recursed too deeply",
    signal.SIGABRT: "native code gave up (abort, or an exception that nobody caught)",
    signal.SIGFPE: "native code divided a whole number by zero",
    signal.SIGBUS: "a file that was mapped into memory got shorter",
    signal.SIGSYS: "it made a system call of another architecture",
    signal.SIGILL: "a library uses instructions that this processor does not have",
    signal.SIGXFSZ: "it wrote a file beyond the limit",
}


def cpu_limit(limits: Limits, used_s: float) -> Failure:
    """Return what is said when the CPU time is used up."""
    sentence = f"The program used {used_s:.1f} s of CPU time; the limit is {limits.cpu_s:g} s."
    return Failure(Verdict.TIME_LIMIT, sentence, "")


def answer_limit(waited_for: str, cpu_s: float) -> Failure:
    """Return what is said when one answer takes too much CPU time."""
    sentence = f"{waited_for} used {cpu_s:g} s of CPU time and did not return."
    return Failure(Verdict.TIME_LIMIT, sentence, "")


def wall_limit(waited_for: str, wall_s: float) -> Failure:
    """Return what is said when an answer does not come."""
    sentence = f"{waited_for} did not return within {wall_s:g} s."
    return Failure(Verdict.TIME_LIMIT, sentence, "")


def run_limit(limits: Limits) -> Failure:
    """Return what is said when the whole run takes too long."""
    sentence = f"The program took more than {limits.wall_s:g} s for all its answers together."
    return Failure(Verdict.TIME_LIMIT, sentence, "")


def memory_limit(limits: Limits) -> Failure:
    """Return what is said when the memory is used up."""
    sentence = f"The program used more than {limits.memory_mib} MiB of memory."
    return Failure(Verdict.MEMORY_LIMIT, sentence, "")


def output_limit(limits: Limits) -> Failure:
    """Return what is said when the program prints too much."""
    sentence = f"The program printed more than {limits.output_max_mib} MiB."
    return Failure(Verdict.OUTPUT_LIMIT, sentence, "")


def process_limit(limits: Limits, trace: str = "") -> Failure:
    """Return what is said when the program ended badly after a process was refused."""
    sentence = f"The program wanted more than {limits.processes} processes and threads."
    return Failure(Verdict.PROCESS_LIMIT, sentence, trace)


def misbehaved(sentence: str) -> Failure:
    """Return what is said when the program breaks the protocol."""
    return Failure(Verdict.PROTOCOL_ERROR, sentence, "")


def died(exit_code: int) -> Failure:
    """Return what is said when the process ended by itself or by a signal."""
    if exit_code == DISCONNECTED:
        return misbehaved("The program closed its connection to the simulator.")
    number = exit_code - SIGNALLED
    if number not in set(signal.Signals):
        sentence = f"The program ended its process (exit code {exit_code}) before the run was over."
        return Failure(Verdict.USER_ERROR, sentence, "")
    name = signal.Signals(number)
    because = f": {BECAUSE[name]}" if name in BECAUSE else ""
    return Failure(Verdict.USER_ERROR, f"The program was ended by {name.name}{because}.", "")
