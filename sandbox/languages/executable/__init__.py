"""An executable that speaks the protocol itself (docs/protocol.md): from any language."""

import struct
from pathlib import Path

from seamark.sandbox.languages.c_family import GCC_PACKAGES, C, run_binary
from seamark.sandbox.languages.language import ALL_ROLES, Calls, Language
from seamark.sandbox.languages.sample import Sample

HERE = Path(__file__).parent
ELF_HEADER = struct.Struct("<4sBBBB8xHH")  # its beginning (System V ABI, "ELF Header")
BUILD = "gcc -O2 -static {source} -o {program}"
MAGIC, BITS_64, LITTLE_ENDIAN, EXECUTABLE_TYPES, X86_64 = b"\x7fELF", 2, 1, (2, 3), 62
MACHINES = {3: "32-bit x86", 40: "32-bit ARM", 183: "64-bit ARM", 243: "RISC-V", X86_64: "x86-64"}


def refusal(program: bytes) -> str:
    """Return why these bytes cannot be started here; empty if they may. Nothing is run."""
    if program.startswith(b"#!"):
        return "A script needs its interpreter, which is not in the sandbox; upload its language."
    if len(program) < ELF_HEADER.size or not program.startswith(MAGIC):
        return "This is not an executable file of Linux (ELF)."
    _, bits, order, _, _, file_type, machine = ELF_HEADER.unpack_from(program)
    if bits != BITS_64 or order != LITTLE_ENDIAN or machine != X86_64:
        name = MACHINES.get(machine, f"machine {machine}")
        size = 64 if bits == BITS_64 else 32
        return f"The executable is for {name} ({size} bits); the sandbox is 64-bit x86-64 Linux."
    if file_type not in EXECUTABLE_TYPES:
        return "This is an object file or a core dump; link it to an executable."
    return ""


EXECUTABLE = Language(
    name="executable",
    label="Executable (64-bit Linux)",
    suffixes=(".elf", ".bin", ".out", ""),
    runtime=run_binary,
    calls=Calls(
        "The program (its start)", "the program's answer to R", "the program's answer to O"
    ),
    self_test=C.self_test,
    starters=(
        Sample(
            files={"controller.c": HERE / "starter/controller.c"},
            build=BUILD,
            heading="An executable in C",
        ),
        Sample(
            files={"controller.c": HERE / "starter/arm_controller.c"},
            moves_arm=True,
            build=BUILD,
            heading="An executable in C",
        ),
    ),
    conformance=C.conformance,
    samples_compiled_by=C.name,
    roles=ALL_ROLES,
    binary_refusal=refusal,
    debian_packages=GCC_PACKAGES,
    noun="a Linux executable",
    syntax=C.syntax,
    in_the_box=(
        "An executable may be static, or linked to the C and C++ libraries of the worker's system."
    ),
)
