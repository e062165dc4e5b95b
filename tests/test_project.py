"""Rules for the whole tree that no linter checks."""

import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ("sandbox", "sim", "server", "worker", "templates", "migrations")
FOREIGN = {".venv", ".boot", "node_modules", "data"}
TESTED = ("performance", "sandbox", "seamark", "server", "sim", "worker")


def tracked(*patterns: str) -> list[Path]:
    """Return the files that git tracks, or all files if the tree is not a checkout."""
    found = _listed_by_git(patterns) or _found_in_folders(patterns)
    assert found
    return found


def _listed_by_git(patterns: tuple[str, ...]) -> list[Path]:
    if shutil.which("git") is None:
        return []
    command = ["git", "ls-files", "-z", "--", *patterns]
    listing = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
    paths = [ROOT / name for name in listing.stdout.decode().split("\0") if name]
    return [path for path in paths if path.is_file()]  # git also lists files just deleted


def _found_in_folders(patterns: tuple[str, ...]) -> list[Path]:
    named = (path for pattern in patterns for path in ROOT.rglob(pattern))
    found = (path for path in named if path.is_file())
    return [path for path in found if not FOREIGN & set(path.relative_to(ROOT).parts)]


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_is_a_folder_of_the_checkout_and_a_link_in_the_namespace(name: str) -> None:
    assert (ROOT / name / "__init__.py").is_file()
    assert (ROOT / "seamark" / name).readlink() == Path("..", name)


def test_the_wheel_installs_the_namespace_alone() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

    assert project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"] == ["seamark"]


@pytest.mark.parametrize("package", TESTED)
def test_the_folders_of_the_tests_are_those_of_the_code(package: str) -> None:
    names = [path.relative_to(ROOT) for path in tracked("*.py") if path.name.startswith("test_")]
    folders = {name.parent.relative_to("tests") for name in names if name.parts[1] == package}

    assert folders
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


def test_a_run_of_all_tests_has_each_of_them() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    run = [ROOT / path for path in settings["tool"]["pytest"]["ini_options"]["testpaths"]]
    tests = [file for file in tracked("*.py") if file.name.startswith("test_")]

    assert [file for file in tests if not {file, *file.parents} & set(run)] == []


def test_contributing_draws_the_layers_of_the_import_contracts() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    drawn = {
        f"{contract['containers'][0].rpartition('.')[2]:<8} "
        + " > ".join(", ".join(layer.split(" | ")) for layer in contract["layers"])
        for contract in contracts
        if contract["type"] == "layers"
    }
    lines = (ROOT / "CONTRIBUTING.md").read_text("utf-8").splitlines()

    assert len(drawn) == 10
    assert drawn <= set(lines)


def test_no_two_modules_import_each_other() -> None:
    graph = grimp.build_graph("seamark", "performance", cache_dir=None)
    assert "seamark.sim.physics.plant" in graph.modules
    mutual = {
        tuple(sorted((module, other)))
        for module in graph.modules
        for other in graph.find_modules_directly_imported_by(module)
        if module in graph.find_modules_directly_imported_by(other)
    }

    assert mutual == set()


def test_no_module_has_a_meaningless_name() -> None:
    meaningless = {"utils", "helpers", "common", "manager"}

    assert [path for path in tracked("*.py") if path.stem in meaningless] == []


def test_every_runner_command_in_the_documents_exists() -> None:
    printed = subprocess.run(
        [str(ROOT / "run"), "help"], capture_output=True, text=True, check=True
    )
    known = set(re.findall(r"^\./run ?([a-z]*)", printed.stdout, re.MULTILINE))
    named = {
        command
        for path in tracked("*.md")
        for command in re.findall(r"^\s*\./run(?: ([a-z]+))?", path.read_text("utf-8"), re.M)
    }

    assert {"", "test"} <= named <= known


@pytest.mark.slow
def test_the_script_writes_where_it_is_called(tmp_path: Path) -> None:
    required = re.search(r"^UV_VERSION=(.+)$", (ROOT / "run").read_text("utf-8"), re.MULTILINE)
    assert required is not None
    synced = tmp_path / "bin" / "uv"  # what it installs is there already
    synced.parent.mkdir()
    synced.write_text(f"#!/bin/sh\necho uv {required[1]}\n", encoding="utf-8")
    synced.chmod(0o755)
    command = [str(ROOT / "run"), "seamark", "init", "mine"]

    answer = subprocess.run(
        command,
        cwd=tmp_path,
        env=os.environ | {"PATH": f"{synced.parent}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )

    assert answer.returncode == 0, answer.stderr
    assert (tmp_path / "mine" / "controller.py").is_file()
    assert not (ROOT / "mine").exists()
