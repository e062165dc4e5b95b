"""The attacks of the probe. This text is sent into a box, never imported.

Prints one line for each: name, tab, what it achieved (nothing if it was stopped).
"""

import ctypes
import os
import socket
from collections.abc import Callable

CLONE_NEWUSER = 0x10000000
PTRACE, KEYCTL, IO_URING_SETUP = 101, 250, 425  # x86_64
PTRACE_ATTACH = 16
AF_VSOCK = 40

libc = ctypes.CDLL(None, use_errno=True)


def host_files(canary: str) -> str:
    """Look for files of the host."""
    names = (
        canary,
        "/etc/passwd",
        "/etc/shadow",
        "/root",
        "/home",
        "/proc/self",
        "/sys/fs",
        "/run",
    )
    return ", ".join(name for name in names if os.access(name, os.F_OK))


def writable(canary: str) -> str:
    """Try to write where nothing may be written."""
    names = ("/", "/usr/lib", "/dev", "/box", "/box/packages/numpy")
    return ", ".join(name for name in names if os.access(name, os.W_OK))


def environment(canary: str) -> str:
    """Look for a variable of the service."""
    return ", ".join(name for name in os.environ if name.startswith("SEAMARK"))


def descriptors(canary: str) -> str:
    """Look for open descriptors other than the standard streams and the socket."""
    numbers = []
    for number in range(256):
        try:
            os.fstat(number)
        except OSError:
            continue
        numbers.append(number)
    return str(numbers) if len(numbers) > 4 else ""


def sockets(canary: str) -> str:
    """Try to create a socket of each family that could reach the outside."""
    got = []
    for family in (socket.AF_INET, socket.AF_UNIX, AF_VSOCK, socket.AF_NETLINK):
        try:
            socket.socket(family, socket.SOCK_DGRAM).close()
        except OSError:
            continue
        got.append(str(int(family)))
    return "families " + ", ".join(got) if got else ""


def namespaces(canary: str) -> str:
    """Try to become root in a new user namespace."""
    return "" if libc.unshare(CLONE_NEWUSER) else "a new user namespace"


def kernel(canary: str) -> str:
    """Try system calls that the filter has to refuse."""
    got = []
    if libc.syscall(PTRACE, PTRACE_ATTACH, os.getppid(), 0, 0) == 0:
        got.append("ptrace")
    if libc.syscall(KEYCTL, 0, -3, 1, 0, 0) >= 0:
        got.append("keyctl")
    if libc.syscall(IO_URING_SETUP, 0, 0) >= 0 or ctypes.get_errno() != 1:
        got.append("io_uring")
    return ", ".join(got)


ATTACKS: tuple[Callable[[str], str], ...] = (
    host_files,
    writable,
    environment,
    descriptors,
    sockets,
    namespaces,
    kernel,
)


class Controller:
    """Attacks when it is constructed."""

    def __init__(self, config: dict[str, str]) -> None:
        for attack in ATTACKS:
            print(f"{attack.__name__}\t{attack(config['canary'])}")

    def step(self, observation: object) -> tuple[float, float, float, float]:
        """Do nothing."""
        return 0.0, 0.0, 0.0, 0.0
