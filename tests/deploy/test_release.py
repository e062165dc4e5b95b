"""What a release consists of."""

import json
import re
import subprocess
import sys
import tomllib

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

from tests.services import compose

ROOT = compose.ROOT


@pytest.fixture(scope="module")
def bill(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The software bill of materials."""
    path = tmp_path_factory.mktemp("release") / "sbom.json"
    command = [sys.executable, str(ROOT / "deploy" / "release.py"), "--sbom", str(path)]
    subprocess.run(command, check=True)
    return path.read_text("utf-8")


def test_the_bill_of_materials_has_the_schema_of_cyclonedx(bill: str) -> None:
    whole = json.loads(bill)
    few = whole | {"components": whole["components"][:2], "dependencies": []}  # all take a minute

    assert JsonStrictValidator(SchemaVersion.V1_5).validate_str(json.dumps(few)) is None


def test_the_bill_of_materials_names_what_a_service_installs_and_nothing_else(bill: str) -> None:
    parts = {part["name"]: part for part in json.loads(bill)["components"]}
    lock = tomllib.loads((ROOT / "uv.lock").read_text("utf-8"))
    locked = {package["name"]: package.get("version") for package in lock["package"]}

    assert {"flask", "celery", "numba", "pybullet", "obstore", "onnxruntime"} <= parts.keys()
    assert not {"pytest", "ruff", "playwright", "seamark"} & parts.keys()
    assert {name: part["version"] for name, part in parts.items()} == {
        name: locked[name] for name in parts
    }
    assert all(part["externalReferences"][0]["hashes"] for part in parts.values())


def test_every_place_has_the_version_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    cited = (ROOT / "CITATION.cff").read_text("utf-8")
    images = (ROOT / "deploy" / "kubernetes" / "seamark.yaml").read_text("utf-8")

    assert f"\nversion: {project['version']}\n" in cited
    assert set(re.findall(r"image: seamark-\w+:(\S+)", images)) == {project["version"]}


def test_the_image_is_built_from_the_lock_runs_as_a_plain_user_and_has_no_tests() -> None:
    lines = (ROOT / "Dockerfile").read_text("utf-8")
    stages = dict(re.findall(r"^FROM \S+ AS (\w+)\n(.*?)(?=^FROM|\Z)", lines, re.M | re.S))
    left_out = (ROOT / ".dockerignore").read_text("utf-8").split()

    assert {"build", "web", "worker"} == set(stages)
    for name in ("web", "worker"):
        assert re.findall(r"^USER (.*)$", stages[name], re.MULTILINE)[-1] == "10001:10001"
        assert "HEALTHCHECK" in stages[name]
    assert stages["build"].count("uv sync --frozen --no-dev --extra server") == 2
    assert "/opt/uv" not in stages["web"] + stages["worker"]
    assert {"tests", "performance", "secrets", ".git", ".venv", "data"} <= set(left_out)


def test_the_image_has_the_same_uv_as_the_script() -> None:
    required = re.search(r"^UV_VERSION=(.+)$", (ROOT / "run").read_text("utf-8"), re.MULTILINE)

    assert required is not None
    assert f"uv=={required[1]}\n" in (ROOT / "Dockerfile").read_text("utf-8")
