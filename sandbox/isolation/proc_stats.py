"""CPU time and memory of a process tree from /proc, where there are no control groups.

Coarser than a control group: clock ticks of 10 ms, sampled. Good enough for one's own programs.
Not from /proc/PID/task/TID/children: many kernels are built without it.
"""

import contextlib
import os
from collections.abc import Iterable

READ_BYTES = 1 << 16  # more than the kernel writes to any of these files
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PARENT_FIELD = 1  # index after the name: state, parent ... (proc(5), field 4)
UTIME_FIELD = 11  # utime stime cutime cstime (fields 14 to 17)


def tree(pid: int) -> list[int]:
    """Return a process and all its descendants."""
    children: dict[int, list[int]] = {}
    for name in os.listdir("/proc"):
        if name.isdigit():
            children.setdefault(parent_of(int(name)), []).append(int(name))
    pids = [pid]
    for one in pids:  # grows during the iteration
        pids += children.get(one, [])
    return pids


def cpu_s(pids: Iterable[int]) -> float:
    """Return the CPU time of processes, including that of their reaped children [s]."""
    fields = map(_stat, pids)
    ticks = sum(sum(map(int, line[UTIME_FIELD : UTIME_FIELD + 4])) for line in fields)
    return ticks / TICKS_PER_S


def threads(pids: Iterable[int]) -> list[int]:
    """Return the ids of all threads of processes."""
    thread_ids: list[int] = []
    for pid in pids:
        with contextlib.suppress(OSError):  # the process ended meanwhile
            thread_ids += map(int, os.listdir(f"/proc/{pid}/task"))
    return thread_ids


def run_queue_waits_s(threads: Iterable[int]) -> dict[int, float]:
    """Return thread -> how long it was ready to run and waited for a core [s]."""
    fields = {thread: _text(f"/proc/{thread}/schedstat").split() for thread in threads}
    return {thread: int(times[1]) / 1e9 for thread, times in fields.items() if times}


def memory_mib(pid: int) -> float:
    """Return the peak of the largest process of a tree [MiB]."""
    return max(map(_peak_kib, tree(pid)), default=0) / 1024


def parent_of(pid: int) -> int:
    """Return the parent's pid; 0 if the process is gone."""
    fields = _stat(pid)
    return int(fields[PARENT_FIELD]) if fields else 0


def uid_of(pid: int) -> int:
    """Return the effective uid of a process on the host; -1 if it is gone."""
    return int(_status(pid, "Uid:", "-1 -1").split()[1])


def _stat(pid: int) -> list[str]:
    """Return the fields after the name, which itself may contain blanks and brackets."""
    return _text(f"/proc/{pid}/stat").rpartition(")")[2].split()


def _peak_kib(pid: int) -> int:
    return int(_status(pid, "VmHWM:", "0 kB").split()[0])


def _status(pid: int, name: str, missing: str) -> str:
    """Return one line of /proc/PID/status; `missing` if the process is gone."""
    for line in _text(f"/proc/{pid}/status").splitlines():
        if line.startswith(name):
            return line.removeprefix(name).strip()
    return missing


def _text(path: str) -> str:
    """Return a small file; not by Path, since a tree is as many files as the host has processes."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            return os.read(descriptor, READ_BYTES).decode(errors="replace")
        finally:
            os.close(descriptor)
    except OSError:  # the process ended meanwhile
        return ""
