"""The interpreter of scripts in a box."""

import sys
from pathlib import Path

import pytest

from seamark.sandbox.languages import script_runtime


def test_an_interpreter_below_a_home_is_outside_of_it_in_the_box(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = tmp_path / "home" / "ann" / "python"
    (installed / "bin").mkdir(parents=True)
    (installed / "lib").mkdir()
    (installed / "bin" / "python3.11").touch()
    (installed / "lib" / "libpython3.11.so.1.0").touch()
    (installed / "lib" / "libpython3.11.so").symlink_to("libpython3.11.so.1.0")
    (tmp_path / "python").symlink_to(installed / "bin" / "python3.11")
    monkeypatch.setattr(script_runtime, "HOMES", (f"{tmp_path}/home/",))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr(sys, "base_prefix", str(installed))
    monkeypatch.setattr(sys, "base_exec_prefix", str(installed))

    command, mounts = script_runtime.interpreter_files()

    assert command[0] == "/box/interpreter/bin/python3.11"
    assert {mount.target: mount.source for mount in mounts} == {
        command[0]: installed / "bin" / "python3.11",
        "/box/interpreter/lib/python3.11": installed / "lib" / "python3.11",
        "/box/interpreter/lib/libpython3.11.so": installed / "lib" / "libpython3.11.so.1.0",
        "/box/interpreter/lib/libpython3.11.so.1.0": installed / "lib" / "libpython3.11.so.1.0",
    }
