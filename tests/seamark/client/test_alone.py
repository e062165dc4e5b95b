"""The distribution `seamark-client` works alone: small, pure Python, without the simulator."""

import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib import metadata
from io import BytesIO
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from seamark.cli.main import OF_CLIENT
from seamark.server.web.own_wheel import CLIENT, OwnWheel
from tests.cast import PROGRAM, Backend
from tests.server.judging.cup import NAME, Cup

SEAMARK = Path(__file__).parents[3] / "seamark"
LARGEST_MB = 15.0
COMPILED_PER_SOURCE = 2.0  # at most: an installation has the sources and their bytecode
HEAVY = ("numpy", "numba", "cv2", "pydantic", "scipy", "rich", "flask", "sqlalchemy")


def _needed(name: str = "seamark-client") -> Iterator[metadata.Distribution]:
    """Yield the distributions that an installation of the client brings."""
    seen, waiting = set[str](), [name]
    while waiting:
        found = metadata.distribution(waiting.pop())
        if found.name not in seen:
            seen.add(found.name)
            yield found
            needs = [Requirement(line) for line in found.requires or ()]
            waiting += [n.name for n in needs if not n.marker or n.marker.evaluate({"extra": ""})]


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of an environment that has the client and what it needs, and nothing else."""
    folder = tmp_path_factory.mktemp("alone")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    (packages,) = (folder / "lib").glob("python*/site-packages")
    wheel = OwnWheel("seamark-client").get("http://water.example")
    zipfile.ZipFile(BytesIO(wheel.content)).extractall(packages)
    for each in _needed():
        for file in each.files or () if each.name != "seamark-client" else ():
            if ".." not in file.parts:
                (packages / file).parent.mkdir(parents=True, exist_ok=True)
                (packages / file).symlink_to(file.locate())
    return folder / "bin/python"


def _call(python: Path, folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    environ = {name: text for name, text in os.environ.items() if not name.startswith("SEAMARK_")}
    return subprocess.run(
        [python, *words], cwd=folder, env=environ, capture_output=True, text=True, check=False
    )


def _seamark(python: Path, folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    return _call(python, folder, "-m", "seamark.cli.main", *words)


def test_what_it_needs_is_small_and_pure_python() -> None:
    others = [each for each in _needed() if each.name != "seamark-client"]
    files = [file for each in others for file in each.files or () if ".." not in file.parts]
    sources = [Path(str(file.locate())) for file in files if file.suffix != ".pyc"]
    own = len(OwnWheel("seamark-client").get("http://water.example").content)
    size_mb = (sum(path.stat().st_size for path in sources) + 4 * own) / 1e6  # unpacked

    assert len(others) < 12
    assert [str(path) for path in sources if path.suffix in {".so", ".pyd"}] == []
    assert size_mb * (1 + COMPILED_PER_SOURCE) < LARGEST_MB


@pytest.mark.slow
def test_it_submits_follows_compares_and_downloads(
    alone: Path, address: str, token: str, worker: None, tmp_path: Path
) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "mine.py").write_bytes(PROGRAM)
    server = ("--server", address, "--token", token)
    (folder / "settings.toml").write_text("kp = 0.7\n", encoding="utf-8")
    mine = ("currents-v1", "--controller", "mine.py", "--config", "settings.toml", "--seed", "3")

    first = _seamark(alone, folder, "submit", *mine, "--set", "ki=0.1", "--wait", *server)
    second = _seamark(alone, folder, "submit", "currents-v1", "--controller", "pi", *server)
    compared = _seamark(alone, folder, "compare", "1", "2", *server)
    board = _seamark(alone, folder, "leaderboard", "currents-v1", *server)
    kept = _seamark(alone, folder, "export", "1", "--format", "csv", "-o", "run.csv", *server)

    for done in (first, second, compared, board, kept):
        assert done.returncode == 0, done.stderr
    assert "Score 50" in first.stdout
    assert "Differences of scores" in compared.stdout
    assert (folder / "run.csv").read_text("utf-8").startswith("# ")


@pytest.mark.slow
def test_it_takes_part_in_a_competition(
    alone: Path, backend: Backend, address: str, token: str, tmp_path: Path
) -> None:
    Cup.opened(backend).team("ann")
    server = ("--server", address, "--token", token)
    entered = ("currents-v1", "--controller", "pi", "--competition", NAME, "--method", "PI")

    sent = _seamark(alone, tmp_path, "submit", *entered, *server)
    shown = _seamark(alone, tmp_path, "competition", "show", NAME, *server)

    assert (sent.returncode, shown.returncode) == (0, 0), sent.stderr + shown.stderr
    assert "Your team is Team ann." in shown.stdout


def test_what_needs_the_simulator_says_how_to_get_it(alone: Path, tmp_path: Path) -> None:
    done = _seamark(alone, tmp_path, "run", "currents-v1", "--controller", "pi")

    assert done.returncode == 2
    assert done.stderr == (
        "Error: seamark run needs the simulator, which seamark-client is without: "
        "pip install seamark.\n"
    )
    result = tmp_path / "result"
    result.mkdir()
    (tmp_path / "audit.json").write_text("{}")
    for words in (
        *(("export", "result", "--format", "csv"), ("compare", "result", "result")),
        *(("competition", "audit", "audit.json"), ("competition", "check", "cup.toml")),
    ):
        done = _seamark(alone, tmp_path, *words)

        assert (done.returncode, "needs the simulator" in done.stderr) == (2, True), done.stderr


def test_its_help_lists_what_it_can_do(alone: Path, tmp_path: Path) -> None:
    shown = _seamark(alone, tmp_path, "--help").stdout.partition("Commands:")[2]
    table = shown.partition("Exit codes:")[0]

    assert {line.split()[0] for line in table.splitlines() if line[2:3].strip()} == OF_CLIENT


def test_the_client_imports_nothing_of_the_simulator(alone: Path, tmp_path: Path) -> None:
    code = (
        "import sys, seamark; seamark.Client('http://water.example').close()\n"
        f"assert not set({HEAVY!r}) & set(sys.modules)\n"
        "try:\n"
        "    import seamark.sim\n"
        "except ModuleNotFoundError:\n"
        "    print('alone')\n"
    )

    assert _call(alone, tmp_path, "-c", code).stdout == "alone\n"


def _settings_of_mypy(folder: Path) -> Path:
    """Write those of the project, but for packages that an installation of the client is without.

    To read SQLAlchemy, Numba, matplotlib and others for a version takes most of the time.
    """
    own = {each.name for each in _needed()}
    others = sorted(
        package
        for package, names in metadata.packages_distributions().items()
        if package.isidentifier() and package != "seamark" and not own & set(names)
    )
    skipped = [f"{package}.*" for package in others]
    override = f"\n[[tool.mypy.overrides]]\nmodule = {skipped}\nfollow_imports = 'skip'\n"
    path = folder / "pyproject.toml"
    path.write_text((SEAMARK.parent / "pyproject.toml").read_text("utf-8") + override, "utf-8")
    return path


@pytest.mark.slow
def test_its_sources_are_for_python_3_10_and_newer(tmp_path: Path) -> None:
    sources = [str(SEAMARK / name) for name in CLIENT if name not in {"cli", "py.typed"}]
    shared: tuple[str, ...] = (
        "main",
        "options",
        "configuration",
        "solutions",
        "extras",
        "results",
        "output_folder",
    )
    shared += ("console", "run_summary", "server_answers", "comparison_tables")
    sources += [str(SEAMARK / "cli" / f"{name}.py") for name in shared]
    sources += [str(SEAMARK / "cli" / "commands" / f"{name}.py") for name in OF_CLIENT]
    options: tuple[str, ...] = (
        "--python-version",
        "3.10",
        "--follow-imports",
        "silent",
        "--no-warn-return-any",
    )
    settings = _settings_of_mypy(tmp_path)

    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, "--config-file", settings, *sources],
        cwd=SEAMARK.parent,
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stdout
