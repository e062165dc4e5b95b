"""Executables that cannot be started here: refused with a reason, and harmless in the box."""

import struct

import pytest

from seamark.programs import preparation
from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.c_family import C
from seamark.sandbox.languages.executable import ELF_HEADER, refusal
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from tests.hostile.conftest import LAYOUT
from tests.services.languages import skip_without


def elf(*, bits: int = 2, machine: int = 62, kind: int = 2, order: int = 1) -> bytes:
    return ELF_HEADER.pack(b"\x7fELF", bits, order, 1, 0, kind, machine) + bytes(200)


CASES = [
    (b"#!/bin/sh\nid\n", "its interpreter"),
    (b"#!/usr/bin/python3\nprint('GOT')\n", "its interpreter"),
    (b"MZ" + bytes(400), "not an executable file of Linux"),
    (b"\x7fELF", "not an executable file of Linux"),
    (elf(bits=1, machine=3), r"32-bit x86 \(32 bits\)"),
    (elf(bits=1), r"x86-64 \(32 bits\)"),  # x32
    (elf(machine=183), "64-bit ARM"),
    (elf(machine=9999), "machine 9999"),
    (elf(order=2), "is for x86-64"),
    (elf(kind=1), "object file"),
    (elf(kind=4), "core dump"),
]


@pytest.fixture(scope="module")
def executables(isolation: IsolationLevel) -> IsolationLevel:
    skip_without("executable", isolation)
    return isolation


def ended(program: bytes, isolation: IsolationLevel) -> Outcome:
    with Box("executable", limits=Limits(start_wall_s=5.0), isolation=isolation) as box:
        try:
            box.load(program, "mine.elf", {}, LAYOUT)
            box.step([0.0] * 6)
            return box.finish()
        except ProgramEnded as end:
            return end.outcome


@pytest.mark.parametrize(("program", "says"), CASES)
def test_what_cannot_run_is_refused_as_an_upload(program, says) -> None:
    with pytest.raises(preparation.UploadRejected, match=says):
        preparation.prepare(program, "mine.elf")


@pytest.mark.host
@pytest.mark.parametrize(("program", "_"), CASES)
def test_what_is_refused_would_end_as_the_users_error(program, _, executables) -> None:
    outcome = ended(program, executables)

    assert outcome.verdict is Verdict.USER_ERROR
    assert b"GOT" not in outcome.output


@pytest.mark.host
def test_a_compiled_program_is_accepted_and_runs(executables) -> None:
    program = compiled("c", C.self_test.upload(), "half.c", isolation=executables)

    assert refusal(program) == ""
    assert preparation.prepare(program, "half").language == "executable"
    assert ended(program, executables).verdict is Verdict.OK


@pytest.mark.host
def test_an_executable_that_speaks_no_protocol_ends_by_its_own_fault(executables) -> None:
    text = (
        C.self_test.text()
        + "#include <stdlib.h>\n__attribute__((constructor)) void f(void) { exit(0); }\n"
    )
    program = compiled("c", text.encode(), "exits.c", isolation=executables)

    outcome = ended(program, executables)

    assert outcome.verdict is Verdict.USER_ERROR
    assert "exit code 0" in outcome.sentence


def test_the_elf_header_has_the_size_of_the_standard() -> None:
    assert ELF_HEADER.size == struct.calcsize("<16sHH")
