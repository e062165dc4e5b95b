"""The example for Kubernetes; `./run release` also checks it against the schemas of Kubernetes."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from seamark.server.settings import Settings
from seamark.server.web import service_gauges
from tests.services import compose

EXAMPLE = compose.ROOT / "deploy" / "kubernetes" / "seamark.yaml"
DOCUMENTS: list[dict[str, Any]] = list(yaml.safe_load_all(EXAMPLE.read_text("utf-8")))


def _named(kind: str, name: str) -> dict[str, Any]:
    [found] = [
        each for each in DOCUMENTS if (each["kind"], each["metadata"]["name"]) == (kind, name)
    ]
    return found


def _containers() -> list[dict[str, Any]]:
    pods = [
        each["spec"]["template"]["spec"] for each in DOCUMENTS if "template" in each.get("spec", {})
    ]
    return [
        one for pod in pods for key in ("initContainers", "containers") for one in pod.get(key, [])
    ]


@pytest.mark.parametrize("container", _containers(), ids=lambda one: one["name"])
def test_the_settings_of_a_container_exist(container: dict[str, Any], tmp_path: Path) -> None:
    given = dict(_named("ConfigMap", "seamark")["data"])
    given |= {each["name"]: each["value"] for each in container["env"]}
    secrets = {text.rsplit("/", 1)[1] for text in given.values() if "/run/secrets/" in text}
    for name in secrets:
        (tmp_path / name).write_text("postgresql://seamark@db/seamark")
    readable = {
        name: text.replace("/run/secrets/seamark", str(tmp_path)) for name, text in given.items()
    }

    assert Settings.load(readable | {"SEAMARK_DATA": str(tmp_path / "data")}).public


@pytest.mark.parametrize("container", _containers(), ids=lambda one: one["name"])
def test_a_container_has_limits_and_no_right_that_it_does_not_need(
    container: dict[str, Any],
) -> None:
    rights = container["securityContext"]

    assert {"cpu", "memory"} == set(container["resources"]["limits"])
    assert rights["readOnlyRootFilesystem"]
    assert not rights["allowPrivilegeEscalation"]
    assert rights["capabilities"]["drop"] == ["ALL"]


def test_a_worker_has_the_rights_of_the_compose_file_and_no_secret_more() -> None:
    [worker] = _named("Deployment", "seamark-worker")["spec"]["template"]["spec"]["containers"]
    rights = worker["securityContext"]

    assert rights["capabilities"]["add"] == compose.service("worker")["cap_add"]
    assert rights["runAsUser"] == 0
    assert "SECRET_KEY_FILE" not in " ".join(each["name"] for each in worker["env"])


def test_workers_follow_a_metric_that_exists() -> None:
    scaling = _named("ScaledObject", "seamark-worker")["spec"]
    [trigger] = scaling["triggers"]
    source = Path(service_gauges.__file__).read_text("utf-8")
    metrics = re.findall(r"seamark_\w+", trigger["metadata"]["query"])

    assert metrics
    assert [name for name in metrics if f'"{name}"' not in source] == []
    assert scaling["scaleTargetRef"]["name"] == "seamark-worker"
    assert 1 <= scaling["minReplicaCount"] < scaling["maxReplicaCount"]
