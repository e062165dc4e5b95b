"""A program behind a bridge moves an arm, and gets what it feels."""

from collections.abc import Iterable, Mapping
from typing import Any

import pytest

from seamark.worker.ipc.outcomes import RunOutcome
from tests.seamark.bridge.conftest import Running
from tests.seamark.bridge.rosbridge.conftest import WITH_ARM, Bridged, Open
from tests.sim.engine.test_arm import Moving

SPEEDS = [0.3, -0.2, 0.1, 0.0, -0.1]
SURGE = 0.2


def publish_speeds(bridged: Bridged, speeds: list[float]) -> Any:
    client = bridged.client()
    client.send(op="publish", topic="/seamark/joint_velocity", msg={"data": speeds})
    return client


def moved(
    open_bridge: Open, topics: Iterable[str], **settings: Any
) -> tuple[RunOutcome, list[dict[str, Any]]]:
    """Run a program that always sends the same speeds; return how, and what it was sent."""
    bridged = open_bridge(joints=len(SPEEDS))
    client = publish_speeds(bridged, SPEEDS)
    outcome = bridged.steered(client, topics, surge=SURGE, **WITH_ARM | settings)
    return outcome, client.others


@pytest.mark.slow
def test_the_speeds_of_joints_go_with_each_reference_from_then_on(open_bridge: Open) -> None:
    direct = Running(Moving((SURGE, 0.0, 0.0, 0.0, *SPEEDS)), **WITH_ARM).outcome()

    topics = ("/seamark/joint_states", "/seamark/wrench", "/seamark/touch")
    outcome, messages = moved(open_bridge, topics)

    assert (outcome.failure, outcome.digest) == (None, direct.digest)
    by_topic: dict[str, Mapping[str, Any]] = {one["topic"]: one["msg"] for one in messages}
    joints = by_topic["/seamark/joint_states"]
    assert joints["name"] == ["shoulder", "upper arm", "forearm", "wrist", "jaw port"]
    assert joints["velocity"][0] == pytest.approx(0.3, abs=0.05)
    assert {*by_topic["/seamark/wrench"]["wrench"]} == {"force", "torque"}
    assert len(by_topic["/seamark/touch"]["data"]) == 3


@pytest.mark.parametrize(
    ("speeds", "words"),
    [([0.1] * 4, "5 joints"), ([0.1] * 99, "16 items"), (["fast"] * 5, "number")],
)
def test_speeds_that_are_no_speeds_of_these_joints_are_refused(
    open_bridge: Open, speeds: list[Any], words: str
) -> None:
    client = publish_speeds(open_bridge(joints=5), speeds)

    status = client.receive()

    assert (status["op"], status["level"]) == ("status", "error")
    assert words in status["msg"]


def test_a_vehicle_without_an_arm_takes_no_speeds_of_joints(open_bridge: Open) -> None:
    client = publish_speeds(open_bridge(), [0.1])

    assert "has no arm" in client.receive()["msg"]
