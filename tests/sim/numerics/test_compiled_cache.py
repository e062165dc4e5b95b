"""Compiled code is never used after a change of the sources that it was compiled from."""

import ast
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from seamark.sim.camera import raycast
from seamark.sim.numerics import libm
from seamark.sim.numerics.compiled_cache import (
    ROOT,
    UNUSED_MAX_S,
    SourceStampLocator,
    imported_names,
    stamp,
)
from seamark.sim.physics.plant import Plant

SOURCES = {
    "sim/__init__.py": "",
    "sim/drag.py": "from seamark.sim.sines import sin\n",
    "sim/sines.py": "import math\n",
    "sim/camera/__init__.py": "from seamark.sim.camera import rays\n",
    "sim/camera/rays.py": "import seamark.sim.drag\n",
    "sim/water.py": "from seamark.sim import tides\n",
    "sim/tides.py": "",
}


def _stamps(folder: Path, **changed: str) -> dict[str, str]:
    for name, text in (SOURCES | changed).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return {name: stamp(folder / name, folder) for name in SOURCES}


@pytest.mark.parametrize(
    ("changed", "affected"),
    [
        (
            "sim/sines.py",
            {"sim/sines.py", "sim/drag.py", "sim/camera/rays.py", "sim/camera/__init__.py"},
        ),
        ("sim/camera/rays.py", {"sim/camera/rays.py", "sim/camera/__init__.py"}),
        ("sim/tides.py", {"sim/tides.py", "sim/water.py"}),
    ],
)
def test_a_change_compiles_again_what_depends_on_it_and_nothing_else(
    tmp_path: Path, changed: str, affected: set[str]
) -> None:
    before = _stamps(tmp_path / "a")
    after = _stamps(tmp_path / "b", **{changed: SOURCES[changed] + "# changed\n"})

    assert {name for name in SOURCES if before[name] != after[name]} == affected


def test_compiled_functions_are_kept_under_the_stamp_of_their_sources() -> None:
    for function, module in ((libm.sin, libm), (raycast.draw, raycast)):
        path = Path(module.__file__).resolve()
        assert (
            Path(function._cache.cache_path).name == f"numba-{path.stem}-{stamp(path, ROOT)[:16]}"
        )


@pytest.mark.slow
def test_code_is_kept_under_the_stamp_also_if_numba_was_imported_before_the_simulator() -> None:
    code = (
        "import numba\nfrom seamark.sim.numerics import libm\nprint(libm.sin._cache.cache_path)\n"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert Path(done.stdout.strip()) == Path(libm.sin._cache.cache_path)


def _by_syntax(source: str) -> set[str]:
    """Return the names in the import statements of a file, from its syntax tree."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)}
    return {name for name in names if name.startswith("seamark")}


@pytest.mark.slow
def test_no_import_of_any_source_is_overlooked() -> None:
    sources = [path.read_text("utf-8") for path in (ROOT / "sim").rglob("*.py")]

    assert sum(map(len, map(_by_syntax, sources))) > 500
    for source in sources:
        assert _by_syntax(source) <= set(imported_names(source))


@pytest.mark.parametrize(
    ("source", "names"),
    [
        ("import os, seamark.sim.drag as d\n", {"seamark.sim.drag"}),
        ("if yes: from seamark.sim import drag\n", {"seamark.sim", "seamark.sim.drag"}),
        (
            "def f():\n    from seamark.sim import (  # drag (all)\n        drag,\n    )\n",
            {"seamark.sim", "seamark.sim.drag"},
        ),
        ("x = 1; import seamark.sim.drag; y = 2\n", {"seamark.sim.drag"}),
        ("import numpy\nfrom numba import njit\n", set()),
    ],
)
def test_imports_are_found_in_every_form(source: str, names: set[str]) -> None:
    assert set(imported_names(source)) == names


def test_code_outside_the_simulator_is_left_to_numba() -> None:
    assert SourceStampLocator.from_function(Plant.pose, "/usr/lib/python3/other.py") is None


def _unused_for(folder: Path, seconds: float) -> Path:
    folder.mkdir()
    (folder / "plant.advance-1.nbc").write_bytes(b"code")
    os.utime(folder, (time.time() - seconds,) * 2)
    return folder


def test_code_of_versions_that_are_no_longer_used_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    path = ROOT / "sim/physics/plant.py"
    own = _unused_for(tmp_path / f"numba-plant-{stamp(path, ROOT)[:16]}", UNUSED_MAX_S + 60)
    _unused_for(tmp_path / f"numba-plant-{16 * 'a'}", UNUSED_MAX_S + 60)
    beside = _unused_for(tmp_path / f"numba-plant-{16 * 'b'}", UNUSED_MAX_S - 60)
    foreign = _unused_for(tmp_path / "numba-notes", UNUSED_MAX_S + 60)

    SourceStampLocator.from_function(Plant.pose, str(path))

    assert sorted(tmp_path.iterdir()) == sorted([own, beside, foreign])
    assert time.time() - own.stat().st_mtime < 60
