"""The system call filter: an allow-list as a classic BPF program, assembled with `struct`.

Calls that are not allowed fail, most with EPERM, so that an honest program gets a readable error. A
foreign calling convention (i386, x32) ends the process: its numbers mean other calls.
Arguments are compared as 32-bit halves, since the kernel uses 32 bits of them (CVE-2019-10063
was a comparison of 64).
"""

import errno
import platform
import struct
from collections.abc import Iterable
from functools import cache

from seamark.sandbox.isolation.argument_rules import REFUSALS, Refusal, Test
from seamark.sandbox.isolation.system_calls import (
    ALLOWED,
    NOT_SUPPORTED,
    NOT_THERE,
    NUMBERS,
    WITHOUT_EFFECT,
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
SUCCESS = 0  # as an error number: the call returns 0

Instruction = tuple[int, int, int, int]  # code, jump if true, jump if false, operand


def supported() -> bool:
    """Return whether the filter knows this machine's system calls."""
    return platform.machine() == MACHINE


@cache
def build() -> bytes:
    """Return the filter as an array of `struct sock_filter`, as `bwrap --seccomp` reads it."""
    program = [
        *_foreign_conventions(),
        *(step for name, refusals in REFUSALS.items() for step in _by_argument(name, refusals)),
        *_always(NOT_THERE, ERRNO | errno.ENOSYS),
        *_always(NOT_SUPPORTED, ERRNO | errno.EOPNOTSUPP),
        *_always(WITHOUT_EFFECT, ERRNO | SUCCESS),
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


def _by_argument(name: str, refusals: Iterable[Refusal]) -> list[Instruction]:
    """Return the instructions that decide one call: it is allowed unless a rule refuses it."""
    body = [instruction for refusal in refusals for instruction in _refused(refusal)]
    body.append((RETURN, 0, 0, ALLOW))
    return [(EQUAL, 0, len(body), NUMBERS[name]), *body]


def _refused(refusal: Refusal) -> list[Instruction]:
    """Return the instructions of one rule, after which the program goes on if it does not apply."""
    answer = (RETURN, 0, 0, ERRNO | refusal.error)
    test = ANY_BIT if refusal.test is Test.ANY_BIT else EQUAL
    body = [_load(refusal.argument)]
    if refusal.test is Test.NOT_LISTED:
        count = len(refusal.values)
        body += [(test, count - index, 0, value) for index, value in enumerate(refusal.values)]
        body.append(answer)
    else:
        body += [step for value in refusal.values for step in ((test, 0, 1, value), answer)]
    if refusal.when is None:
        return body
    position, value = refusal.when
    return [_load(position), (EQUAL, 0, len(body), value), *body]


def _load(argument: int) -> Instruction:
    """Return the instruction that loads the lower half of an argument."""
    return (LOAD, 0, 0, ARGUMENTS_OFFSET + 8 * argument)
