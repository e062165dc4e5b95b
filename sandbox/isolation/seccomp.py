"""The system call filter: an allow-list as a classic BPF program, assembled with `struct`.

Calls that are not allowed fail with EPERM, so that an honest program gets a readable error. A
foreign calling convention (i386, x32) ends the process: its numbers mean other calls.
Arguments are compared as 32-bit halves, since the kernel uses 32 bits of them (CVE-2019-10063
was a comparison of 64).
"""

import errno
import platform
import struct
from collections.abc import Iterable

from seamark.sandbox.isolation.system_calls import (
    AF_UNIX,
    ALLOWED,
    CLONE_NEW_NAMESPACES,
    FCNTL_REFUSED,
    IOCTL_ALLOWED,
    NOT_THERE,
    NUMBERS,
    PRCTL_ALLOWED,
)

MACHINE = "x86_64"  # the only one whose numbers are in system_calls.py

# linux/bpf_common.h: load word at an absolute offset, jump if equal / at least / any bit, return
LOAD, EQUAL, AT_LEAST, ANY_BIT, RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
# linux/seccomp.h
ALLOW, KILL_PROCESS, ERRNO = 0x7FFF0000, 0x80000000, 0x00050000
AUDIT_ARCH_X86_64 = 0xC000003E  # linux/audit.h
X32_BIT = 0x40000000
# struct seccomp_data: number 0, architecture 4, instruction pointer 8, arguments from 16, 8 each
NUMBER_OFFSET, ARCHITECTURE_OFFSET, ARGUMENTS_OFFSET = 0, 4, 16

REFUSE = ERRNO | errno.EPERM

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, operand


def supported() -> bool:
    """Return whether the filter knows this machine's system calls."""
    return platform.machine() == MACHINE


def build() -> bytes:
    """Return the filter as an array of `struct sock_filter`, as `bwrap --seccomp` reads it."""
    program = [
        *_foreign_conventions(),
        *_by_argument("clone", 0, ANY_BIT, (CLONE_NEW_NAMESPACES,), match=REFUSE, other=ALLOW),
        *_by_argument("socketpair", 0, EQUAL, (AF_UNIX,), match=ALLOW, other=REFUSE),
        *_by_argument("ioctl", 1, EQUAL, IOCTL_ALLOWED, match=ALLOW, other=ERRNO | errno.ENOTTY),
        *_by_argument("prctl", 0, EQUAL, PRCTL_ALLOWED, match=ALLOW, other=REFUSE),
        *_by_argument("fcntl", 1, EQUAL, FCNTL_REFUSED, match=REFUSE, other=ALLOW),
        *_by_argument("prlimit64", 0, EQUAL, (0,), match=ALLOW, other=REFUSE),  # own process only
        *_always(NOT_THERE, ERRNO | errno.ENOSYS),
        *_always(sorted(ALLOWED, key=lambda name: NUMBERS[name]), ALLOW),
        (RETURN, 0, 0, REFUSE),
    ]
    return b"".join(struct.pack("=HBBI", *instruction) for instruction in program)


def _foreign_conventions() -> list[Instruction]:
    return [
        (LOAD, 0, 0, ARCHITECTURE_OFFSET),
        (EQUAL, 1, 0, AUDIT_ARCH_X86_64),
        (RETURN, 0, 0, KILL_PROCESS),
        (LOAD, 0, 0, NUMBER_OFFSET),
        (AT_LEAST, 0, 1, X32_BIT),
        (RETURN, 0, 0, KILL_PROCESS),
    ]


def _always(names: Iterable[str], action: int) -> list[Instruction]:
    return [
        instruction
        for name in names
        for instruction in ((EQUAL, 0, 1, NUMBERS[name]), (RETURN, 0, 0, action))
    ]


def _by_argument(
    name: str, argument: int, test: int, values: Iterable[int], *, match: int, other: int
) -> list[Instruction]:
    """Return the instructions that decide one call by the lower half of one argument."""
    body: list[Instruction] = [(LOAD, 0, 0, ARGUMENTS_OFFSET + 8 * argument)]
    for value in values:
        body += [(test, 0, 1, value), (RETURN, 0, 0, match)]
    body.append((RETURN, 0, 0, other))
    return [(EQUAL, 0, len(body), NUMBERS[name]), *body]
