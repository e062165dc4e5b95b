"""The interpreter of scripts in a box."""

import subprocess
import sys
from pathlib import Path

import pytest

from seamark.sandbox.languages import script_runtime

HERE = Path(script_runtime.__file__).parent
SLOW = {"pathlib", "subprocess", "typing", "zipfile"}  # each takes milliseconds of every start


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


@pytest.mark.parametrize(
    ("language", "script"),
    [
        ("c_family", "compile_source"),
        ("c_family", "program"),
        ("matlab", "octave"),
        ("matlab", "relay"),
    ],
)
def test_a_script_imports_nothing_slow_at_the_start_of_a_box(
    tmp_path: Path, language: str, script: str
) -> None:
    inside = HERE / language / "inside"
    package = tmp_path / script_runtime.PACKAGE
    (package / language).mkdir(parents=True)
    (package / "inside").symlink_to(script_runtime.SHARED)
    (package / language / "inside").symlink_to(inside)
    name = script_runtime.module_name(inside, script)
    command = [sys.executable, "-s", "-P", "-S", "-c", f"import sys, {name}; print(*sys.modules)"]

    done = subprocess.run(
        command, env={"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=True
    )

    loaded = set(done.stdout.split())
    assert name in loaded
    assert loaded.isdisjoint(SLOW)
