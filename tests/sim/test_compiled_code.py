"""Compiled code belongs to the sources it was made of."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import sim


def _cache_folder(root: Path, **variables: str) -> str:
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    code = "import os, sim; print(os.environ['NUMBA_CACHE_DIR'])"
    return subprocess.run(
        [sys.executable, "-P", "-c", code],
        env=environment | {"PYTHONPATH": str(root)} | variables,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()


def test_a_change_in_a_source_file_that_others_call_makes_a_new_cache(tmp_path: Path) -> None:
    sources = Path(sim.__file__).parent
    shutil.copytree(sources, tmp_path / "sim", ignore=shutil.ignore_patterns("__pycache__"))
    before = _cache_folder(tmp_path)

    with (tmp_path / "sim" / "elementary.py").open("a") as file:
        file.write("# changed\n")

    assert _cache_folder(tmp_path) != before


def test_a_child_process_uses_the_cache_of_its_parent() -> None:
    root = Path(sim.__file__).parent.parent
    parent = _cache_folder(root)

    assert _cache_folder(root, NUMBA_CACHE_DIR=parent) == parent
