"""An executable that speaks the protocol itself (docs/protocol.md): any language that makes one."""

import struct

from seamark.sandbox.languages.c import running
from seamark.sandbox.languages.language import Calls, Language
from seamark.sandbox.languages.native import GCC, ROLES, SELF_TEST

CALLS = Calls("The program (its start)", "the program's answer to R", "the program's answer to O")
IDENTITY = struct.Struct("<4sBBBB8xHH")  # of an ELF file (System V ABI, "ELF Header")
MAGIC, BITS_64, LITTLE, KINDS, X86_64 = b"\x7fELF", 2, 1, (2, 3), 62
MACHINES = {3: "32-bit x86", 40: "32-bit ARM", 183: "64-bit ARM", 243: "RISC-V", X86_64: "x86-64"}


def refusal(program: bytes) -> str:
    """Return why these bytes cannot be started here; empty if they may. Nothing is run."""
    if program.startswith(b"#!"):
        return "A script needs its interpreter, which is not in the sandbox; upload its language."
    if len(program) < IDENTITY.size or not program.startswith(MAGIC):
        return "This is not an executable file of Linux (ELF)."
    _, bits, order, _, _, kind, machine = IDENTITY.unpack_from(program)
    if bits != BITS_64 or order != LITTLE or machine != X86_64:
        name = MACHINES.get(machine, f"machine {machine}")
        size = 64 if bits == BITS_64 else 32
        return f"The executable is for {name} ({size} bits); the sandbox is 64-bit x86-64 Linux."
    if kind not in KINDS:
        return "This is an object file or a core dump; link it to an executable."
    return ""


EXECUTABLE = Language(
    *("executable", "Executable (64-bit Linux)", (".elf", ".bin", ".out", ""), running, SELF_TEST),
    calls=CALLS,
    roles=ROLES,
    refusal=refusal,
    tested_by="c",
    packages=GCC,
)
