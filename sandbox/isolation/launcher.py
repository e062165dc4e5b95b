"""Started as a process of its own: takes on groups, limits and uid, then becomes bubblewrap.

A program of its own and not a function between fork and exec: forking a large process with
threads and running Python there is neither quick nor safe. It imports as little as it can: each
millisecond here is one of every start.

Arguments: orders as NAME=VALUE in the order in which they are carried out (`group` may come more
than once), `--`, the command.
"""

import os
import resource
import sys


def main() -> None:
    """Carry out the orders, become the command."""
    split = sys.argv.index("--")
    for order in sys.argv[1:split]:
        name, _, value = order.partition("=")
        if name == "descriptors":
            renumber(*map(int, value.split(",")))
        elif name == "group":
            write(value, b"0")
        elif name == "core":
            os.sched_setaffinity(0, {int(value)})
        elif name == "uid":
            become(int(value))
        else:
            resource.setrlimit(getattr(resource, name), (int(value), int(value)))
    os.umask(0o077)
    os.setsid()
    os.chdir("/")
    command = sys.argv[split + 1 :]
    # bubblewrap's own start environment can be read inside as /proc/1/environ: it is empty.
    os.execve(command[0], command, {})  # noqa: S606


def renumber(first: int, *inherited: int) -> None:
    """Give the inherited descriptors the numbers from the first on, in their order.

    Each copy's number grows and is at least its final one, so that none is lost under another.
    """
    copies = [os.dup(number) for number in inherited]
    for number in inherited:
        os.close(number)
    for final, copy in enumerate(copies, start=first):
        os.dup2(copy, final)
        os.set_inheritable(final, True)


def become(uid: int) -> None:
    """Be another user from now on, in no group of others."""
    os.setgroups([])
    os.setresgid(uid, uid, uid)
    os.setresuid(uid, uid, uid)


def write(path: str, text: bytes) -> None:
    """Write to a file of the kernel."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    os.write(descriptor, text)
    os.close(descriptor)


if __name__ == "__main__":
    write("/proc/self/oom_score_adj", b"1000")  # the kernel takes the box before others
    main()
