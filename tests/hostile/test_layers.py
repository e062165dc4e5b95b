"""The tests notice when one layer is switched off: each stops something that no other does."""

import os
import socket
from dataclasses import replace
from pathlib import Path

import pytest

from seamark.sandbox.isolation.bwrap_command import NAMESPACES
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import Layers

pytestmark = pytest.mark.host

LAYERS = Path(__file__).with_name("layers")
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="needs root")

# Stopped by the filter only.
STOPPED_BY_FILTER = (
    "network_unix",
    "network_udp",
    "network_vsock",
    "network_file_lock",
    "secrets_symlink",
    "secrets_fifo",
    "exhaustion_memfd",
    "regression_judge0_cve_2024_28185",
    "regression_judge0_cve_2024_28189",
    "regression_judge0_cve_2024_29021",
)
# Namespace -> the program that notices when it is missing. The filter also stops all network and
# System V calls: they are tried without it.
STOPPED_BY_NAMESPACE = {"pid": "sees_processes", "uts": "sees_name"}


@pytest.fixture
def all_layers(isolation: IsolationLevel) -> Layers:
    return Layers.of(isolation)


@pytest.fixture
def strong(isolation: IsolationLevel) -> None:
    if isolation is not IsolationLevel.STRONG:
        pytest.skip("needs control groups")


def without(name: str) -> tuple[str, ...]:
    return tuple(namespace for namespace in NAMESPACES if namespace != name)


@pytest.mark.parametrize("program", sorted(LAYERS.glob("*.py")), ids=lambda path: path.stem)
def test_with_all_layers_no_attack_succeeds(program, run, isolation) -> None:
    if program.stem == "memory_together" and isolation is not IsolationLevel.STRONG:
        pytest.skip("without control groups nothing counts for the whole box")

    outcome = run(program, port=9)

    assert b"GOT" not in outcome.output


@pytest.mark.parametrize("name", STOPPED_BY_FILTER)
def test_the_suite_notices_when_the_filter_is_off(name, run, all_layers) -> None:
    outcome = run(name, layers=replace(all_layers, seccomp=False))

    assert b"GOT" in outcome.output


@pytest.mark.parametrize(("namespace", "name"), STOPPED_BY_NAMESPACE.items())
def test_the_suite_notices_when_a_namespace_is_off(namespace, name, run, all_layers) -> None:
    layers = replace(all_layers, namespaces=without(namespace))

    assert b"GOT" in run(LAYERS / f"{name}.py", layers=layers).output


def test_the_network_is_held_twice_by_its_namespace_and_by_the_filter(run, all_layers) -> None:
    program = LAYERS / "reaches_network.py"
    open_network = replace(all_layers, namespaces=without("net"))
    no_filter = replace(all_layers, seccomp=False)
    neither = replace(open_network, seccomp=False)

    with socket.create_server(("127.0.0.1", 0)) as service:
        port = service.getsockname()[1]
        assert b"held" in run(program, layers=open_network, port=port).output
        assert b"held" in run(program, layers=no_filter, port=port).output
        assert b"GOT" in run(program, layers=neither, port=port).output


@pytest.mark.usefixtures("strong")
def test_the_suite_notices_when_the_control_groups_are_off(run, all_layers) -> None:
    program = LAYERS / "memory_together.py"

    assert b"GOT" in run(program, layers=replace(all_layers, cgroups=False)).output


@as_root
def test_the_suite_notices_when_a_box_keeps_the_workers_uid(run, all_layers) -> None:
    outcome = run(
        "regression_bubblewrap_root_keeps_uid_0", layers=replace(all_layers, own_uid=False)
    )

    assert b"GOT a uid without limits" in outcome.output
