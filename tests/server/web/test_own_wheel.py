"""The wheels that the service offers have the files of its version, and nothing else."""

import base64
import csv
import hashlib
import io
import json
import os
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

from seamark.server.pages.docs.docs import EXTRAS
from seamark.server.web.own_wheel import CLIENT, LEFT_OUT, MADE_HERE, TAGS, OwnWheel, Wheel
from seamark.sim.numerics.numba_internals import numba_folder

ROOT = Path(__file__).parents[3]
HOST = "http://water.example"
NEEDED = {  # read while the service or a run is under way
    "seamark/docs/benchmarks.md",
    "seamark/docs/figures/p-and-pi.png",
    "seamark/migrations/env.py",
    "seamark/sandbox/languages/c_family/runner.c",
    "seamark/sandbox/languages/c_family/seamark.h",
    "seamark/sandbox/languages/matlab/inside/runner.m",
    "seamark/sandbox/languages/python/starter/controller.py",
    "seamark/sandbox/isolation/launcher.py",
    "seamark/sim/benchmarks/reference_results.json",
    "seamark/sim/camera/textures/grass.png",
    "seamark/sim/trackers/visp/bridge.cpp",
    "seamark/templates/layout/base.html",
    "seamark/templates/static/vendor/three/three.min.js",
}


@pytest.fixture(scope="module")
def wheels() -> dict[str, Wheel]:
    return {name: OwnWheel(name).get(HOST) for name in TAGS}


@pytest.fixture(scope="module")
def names(wheels: dict[str, Wheel]) -> list[str]:
    return [name for wheel in wheels.values() for name in _opened(wheel).namelist()]


def _opened(wheel: Wheel) -> zipfile.ZipFile:
    return zipfile.ZipFile(io.BytesIO(wheel.content))


@pytest.fixture(scope="module")
def installed(wheels: dict[str, Wheel], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A virtual environment with both wheels; of the other packages it sees those of the tests."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    (packages,) = (folder / "lib").glob("python*/site-packages")
    for wheel in wheels.values():
        _opened(wheel).extractall(packages)
    (others,) = {path for path in map(Path, sys.path) if path.name == "site-packages"}
    (packages / "others.pth").write_text(f"{others}\n")
    return folder / "bin/python"


def _tracked(folder: str) -> Iterator[str]:
    listing = subprocess.run(
        ["git", "ls-files", folder], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return (f"seamark/{name.removeprefix('seamark/')}" for name in listing.stdout.splitlines())


@pytest.mark.slow
def test_only_the_name_seamark_is_taken(names: list[str]) -> None:
    tops = {name.partition("/")[0] for name in names}

    assert {top for top in tops if not top.endswith(".dist-info")} == {"seamark"}
    assert len(tops) == 3


def test_it_has_what_is_read_at_run_time_and_nothing_that_was_made_here(names: list[str]) -> None:
    assert sorted(NEEDED - set(names)) == []
    assert [name for name in names if "__pycache__" in name or "bridge-" in name] == []


def test_no_file_is_in_both(names: list[str]) -> None:
    assert len(names) == len(set(names))


def test_the_simulator_takes_the_client_from_the_same_service(wheels: dict[str, Wheel]) -> None:
    (path,) = (n for n in _opened(wheels["seamark"]).namelist() if n.endswith("/METADATA"))
    metadata = _opened(wheels["seamark"]).read(path).decode()

    address = f"{HOST}/download/{wheels['seamark-client'].name}"
    assert f"Requires-Dist: seamark-client @ {address}\n" in metadata
    assert "seamark-client==" not in metadata


@pytest.mark.parametrize(
    "folder", ["migrations", "sandbox", "server", "sim", "templates", "worker"]
)
def test_it_has_every_file_of_the_sources(names: list[str], folder: str) -> None:
    assert sorted(set(_tracked(folder)) - set(names)) == []


@pytest.mark.parametrize("distribution", TAGS)
def test_its_record_lists_each_file_with_its_hash(
    wheels: dict[str, Wheel], distribution: str
) -> None:
    archive = _opened(wheels[distribution])
    (record,) = (name for name in archive.namelist() if name.endswith("/RECORD"))
    rows = list(csv.reader(archive.read(record).decode().splitlines()))

    assert [row[0] for row in rows] == archive.namelist()
    for path, digest, size in rows[:-1]:
        data = archive.read(path)
        found = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        assert (digest, int(size)) == (f"sha256={found}", len(data))
    assert rows[-1] == [record, "", ""]


@pytest.mark.slow
@pytest.mark.parametrize("distribution", TAGS)
def test_it_is_the_same_each_time(wheels: dict[str, Wheel], distribution: str) -> None:
    assert OwnWheel(distribution).get(HOST) == wheels[distribution]


def test_the_build_leaves_out_the_same_and_has_the_same_tags() -> None:
    simulator, client = (
        tomllib.loads((ROOT / folder / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]
        for folder in (".", "deploy/client")
    )
    build = simulator["build"]["targets"]["wheel"]
    hook = client["build"]["targets"]["wheel"]["hooks"]["custom"]

    assert build["packages"] == ["seamark"]
    left_out = [*LEFT_OUT, f"{MADE_HERE}*", *(f"/seamark/{name}" for name in CLIENT)]
    assert build["exclude"] == left_out
    assert build["hooks"]["custom"]["tag"] == TAGS["seamark"]
    assert (tuple(hook["files"]), hook.get("tag")) == (CLIENT, None)


def test_the_simulator_depends_on_the_client_of_its_own_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]

    assert f"seamark-client=={project['version']}" in project["dependencies"]
    assert version("seamark-client") == project["version"]


def test_the_page_about_installing_explains_every_extra() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))

    assert set(EXTRAS) == set(project["project"]["optional-dependencies"])


def test_an_extra_is_installed_from_where_the_wheel_came_from(
    installed: Path, tmp_path: Path
) -> None:
    (metadata,) = (installed.parents[1] / "lib").glob("python*/site-packages/seamark-*.dist-info")
    origin = {"url": "http://water.example/seamark.whl", "archive_info": {}}
    (metadata / "direct_url.json").write_text(json.dumps(origin))
    code = "from seamark.cli.extras import install_line; print(install_line('gym'))"

    done = subprocess.run(
        [installed, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )

    assert done.stdout == 'pip install "seamark[gym] @ http://water.example/seamark.whl"\n'


@pytest.mark.slow
def test_a_service_of_packages_that_it_would_not_see_is_refused(
    installed: Path, tmp_path: Path
) -> None:
    done = subprocess.run(
        [Path(sys.executable).resolve(), "-m", "seamark.cli.main", "up", "--data", "data"],
        cwd=tmp_path,
        env={"PYTHONUSERBASE": str(installed.parents[1])},  # as `pip install --user` leaves it
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )

    assert done.returncode == 2, done.stderr
    assert "needs a virtual environment, pipx or uv" in done.stderr


@pytest.mark.slow
def test_it_runs_beside_folders_with_the_names_of_the_checkout(
    installed: Path, tmp_path: Path
) -> None:
    for name in ("sim", "server", "worker", "sandbox", "templates"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('the wrong package')\n")
    settings = ("levels=0", "level_duration_s=2", "settle_s=1")
    options = [part for setting in settings for part in ("--set", setting)]

    done = subprocess.run(
        [installed, "-m", "seamark.cli.main", "run", "currents-v1", "--seed", "7", *options],
        cwd=tmp_path,
        # It is named after the sources: equal files find what those of the checkout compiled.
        env=os.environ | {"NUMBA_CACHE_DIR": str(numba_folder(os.environ))},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stderr
    assert "digest" in done.stdout


@pytest.mark.slow
def test_an_installed_package_keeps_compiled_code_in_the_cache_folder(
    installed: Path, tmp_path: Path
) -> None:
    code = (
        "from seamark.server.pages import guides\n"
        "from seamark.sim.numerics import numba_internals\n"
        "from seamark.sim.trackers.visp.installation import bridge_path\n"
        "print(numba_internals.numba_folder({'XDG_CACHE_HOME': '/big'}))\n"
        "print(bridge_path().parent)\n"
        "print(guides.FOLDER, len(guides.titles()) > 10)\n"
    )

    done = subprocess.run(
        [installed, "-c", code],
        cwd=tmp_path,
        env={"XDG_CACHE_HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )

    numba, bridge, docs = done.stdout.splitlines()
    assert (numba, bridge) == ("/big/seamark", str(tmp_path / "seamark"))
    assert docs.endswith("site-packages/seamark/docs True")
