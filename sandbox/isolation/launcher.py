"""Sets cgroups, limits and uid of its own process, then becomes bubblewrap.

A separate program, not a function between fork and exec: forking a large process with threads and
running Python in the child is neither fast nor safe. It imports as little as possible, since each
millisecond here is part of every start.

Arguments: steps as NAME=VALUE, in the order in which they are taken (`cgroup` may be repeated),
`--`, the command.
"""

import os
import resource
import sys


def main() -> None:
    """Take the steps, become the command."""
    split = sys.argv.index("--")
    for step in sys.argv[1:split]:
        name, _, value = step.partition("=")
        if name == "descriptors":
            renumber(*map(int, value.split(",")))
        elif name == "cgroup":
            write(value, b"0")
        elif name == "core":
            os.sched_setaffinity(0, {int(value)})
        elif name == "uid":
            set_uid(int(value))
        else:
            limit(getattr(resource, name), int(value))
    os.umask(0o077)
    os.setsid()
    os.chdir("/")
    command = sys.argv[split + 1 :]
    # bubblewrap's initial environment could be read inside as /proc/1/environ: it is empty.
    os.execve(command[0], command, {})  # noqa: S606


def renumber(first: int, *inherited: int) -> None:
    """Renumber the inherited descriptors from `first` on, in their order.

    The copies' numbers increase and are at least their final ones, so that none is overwritten.
    """
    copies = [os.dup(number) for number in inherited]
    for number in inherited:
        os.close(number)
    for final, copy in enumerate(copies, start=first):
        os.dup2(copy, final)
        os.set_inheritable(final, True)


def limit(number: int, value: int) -> None:
    """Limit a resource, at most to what this process may have itself."""
    _, hard = resource.getrlimit(number)
    bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(number, (bound, bound))


def set_uid(uid: int) -> None:
    """Become another user, without supplementary groups."""
    os.setgroups([])
    os.setresgid(uid, uid, uid)
    os.setresuid(uid, uid, uid)


def write(path: str, text: bytes) -> None:
    """Write to a file of the kernel (/proc or cgroup)."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    os.write(descriptor, text)
    os.close(descriptor)


if __name__ == "__main__":
    write("/proc/self/oom_score_adj", b"1000")  # out of memory, the kernel kills the box first
    main()
