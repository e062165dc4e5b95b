"""Rules of the whole tree that no linter checks."""

import re
import shutil
import subprocess
from importlib.metadata import packages_distributions
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parent.parent
PARTS = ("sandbox", "sim", "server", "worker", "templates", "migrations")
TESTED = ("performance", "sandbox", "seamark", "server", "sim", "worker")


def tracked(*patterns: str) -> list[Path]:
    """Return the files git knows, or all files where the tree is not a checkout."""
    if shutil.which("git") is not None:
        command = ["git", "ls-files", "-z", "--", *patterns]
        listing = subprocess.run(command, cwd=ROOT, capture_output=True, check=False)
        if listing.returncode == 0:  # else it is an archive, or somebody else's checkout
            return [ROOT / name for name in listing.stdout.decode().split("\0") if name]
    foreign = {".venv", ".boot", "data"}
    found = (path for pattern in patterns for path in ROOT.rglob(pattern))
    return [path for path in found if not foreign & set(path.relative_to(ROOT).parts)]


@pytest.mark.parametrize("name", PARTS)
def test_a_part_is_a_folder_of_the_checkout_and_a_link_below_the_namespace(name: str) -> None:
    assert (ROOT / name / "__init__.py").is_file()
    assert (ROOT / "seamark" / name).readlink() == Path("..", name)


def test_the_distribution_owns_the_namespace_alone() -> None:
    assert set(packages_distributions().get("seamark", [])) <= {"seamark"}


def test_no_source_file_is_longer_than_400_lines() -> None:
    sources = [
        path
        for path in tracked("*.py", "*.js", "*.css", "run")
        if "vendor" not in path.parts and "versions" not in path.parts and path.is_file()
    ]
    too_long = {
        str(path.relative_to(ROOT)): lines
        for path in sources
        if (lines := path.read_text(encoding="utf-8").count("\n")) > 400
    }

    assert sources
    assert too_long == {}


@pytest.mark.parametrize("package", TESTED)
def test_the_folders_of_the_tests_are_those_of_the_code(package: str) -> None:
    names = [path.relative_to(ROOT) for path in tracked("*.py") if path.name.startswith("test_")]
    folders = {name.parent.relative_to("tests") for name in names if name.parts[1] == package}

    assert folders
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


def test_no_two_modules_import_each_other() -> None:
    graph = grimp.build_graph("seamark", "performance", cache_dir=None)
    mutual = {
        tuple(sorted((module, other)))
        for module in graph.modules
        for other in graph.find_modules_directly_imported_by(module)
        if module in graph.find_modules_directly_imported_by(other)
    }

    assert mutual == set()


def test_no_file_has_a_name_that_says_nothing() -> None:
    empty_names = {"utils", "helpers", "common", "manager"}

    assert [path for path in tracked("*.py") if path.stem in empty_names] == []


def test_every_runner_command_in_the_documents_exists() -> None:
    known = set(re.findall(r"^\./run ?([a-z]*)", subprocess_help(), re.MULTILINE))
    documents = [path for path in tracked("*.md") if path.is_file()]
    named = {
        command
        for path in documents
        for command in re.findall(r"^\s*\./run(?: ([a-z]+))?", path.read_text("utf-8"), re.M)
    }

    assert {"test", "doctor"} <= known
    assert named <= known


def subprocess_help() -> str:
    """Return what `./run help` prints."""
    return subprocess.run(
        [str(ROOT / "run"), "help"], capture_output=True, text=True, check=True
    ).stdout
