"""What a release consists of."""

import email.parser
import io
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile

import pytest
import trove_classifiers

from deploy.hatch_hooks import readme_for_registry
from seamark.server.web.own_wheel import TAGS, OwnWheel, file_name
from tests.services import compose

ROOT = compose.ROOT


@pytest.fixture(scope="module")
def bill(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The software bill of materials."""
    path = tmp_path_factory.mktemp("release") / "sbom.json"
    command = [sys.executable, str(ROOT / "deploy" / "release.py"), "--sbom", str(path)]
    subprocess.run(command, check=True)
    return path.read_text("utf-8")


@pytest.mark.slow
@pytest.mark.long  # the parsers; what is in the bill is looked at below
def test_the_bill_of_materials_has_the_schema_of_cyclonedx(bill: str) -> None:
    # Here: it builds 39 parsers, which every process that collects the tests would do.
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    whole = json.loads(bill)
    few = whole | {"components": whole["components"][:2], "dependencies": []}  # all take a minute

    assert JsonStrictValidator(SchemaVersion.V1_5).validate_str(json.dumps(few)) is None


def test_the_bill_of_materials_names_what_a_service_installs_and_nothing_else(bill: str) -> None:
    parts = {part["name"]: part for part in json.loads(bill)["components"]}
    lock = tomllib.loads((ROOT / "uv.lock").read_text("utf-8"))
    locked = {package["name"]: package.get("version") for package in lock["package"]}

    assert {"flask", "celery", "numba", "pybullet", "obstore", "onnxruntime"} <= parts.keys()
    assert not {"pytest", "ruff", "playwright", "seamark", "seamark-client"} & parts.keys()
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


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, zipfile.ZipFile]:
    """The wheels that a release has, by their distributions."""
    folder = tmp_path_factory.mktemp("dist")
    for project in (ROOT, ROOT / "deploy" / "client"):
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
        environ = os.environ | {"SEAMARK_SOURCE_URL": "https://source.example/seamark/"}
        subprocess.run(command, cwd=project, env=environ, check=True, capture_output=True)
    return {name: zipfile.ZipFile(folder / file_name(name)) for name in TAGS}


@pytest.mark.slow
@pytest.mark.parametrize("name", TAGS)
def test_a_release_has_the_files_that_a_service_offers(
    built: dict[str, zipfile.ZipFile], name: str
) -> None:
    offered = zipfile.ZipFile(io.BytesIO(OwnWheel(name).get("http://water.example").content))
    ours, theirs = (
        {path: one.read(path) for path in one.namelist() if path.startswith("seamark/")}
        for one in (built[name], offered)
    )

    assert ours == theirs


@pytest.mark.parametrize("name", TAGS)
def test_a_registry_is_told_what_it_shows(built: dict[str, zipfile.ZipFile], name: str) -> None:
    (path,) = (path for path in built[name].namelist() if path.endswith("/METADATA"))
    told = email.parser.Parser().parsestr(built[name].read(path).decode())
    classifiers = told.get_all("Classifier", [])

    assert told["Author"] == "The Seamark developers"
    assert "Source, https://source.example/seamark" in told.get_all("Project-URL", [])
    assert set(classifiers) <= trove_classifiers.classifiers
    assert len(classifiers) == len(set(classifiers)) > 8
    assert re.findall(r"\]\((?!https?:|#)[^)]*\)", str(told.get_payload())) == []


def test_links_of_the_readme_lead_to_the_source_or_become_text() -> None:
    text = "[![Run](docs/run.webp)](docs/run.md), [guide](docs/a.md#x) [site](https://a.example)"

    told = readme_for_registry(text, "https://s.example")

    assert readme_for_registry(text, "") == "*Run*, guide [site](https://a.example)"
    assert told == (
        "[![Run](https://s.example/raw/HEAD/docs/run.webp)]"
        "(https://s.example/blob/HEAD/docs/run.md), "
        "[guide](https://s.example/blob/HEAD/docs/a.md#x) [site](https://a.example)"
    )
