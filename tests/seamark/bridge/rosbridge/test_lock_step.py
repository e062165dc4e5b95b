"""A program behind a bridge runs in lock step, and ends as data if it breaks the rules."""

import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from seamark.programs.failure_reasons import FailureReason
from tests.seamark.bridge.conftest import Running, built_in
from tests.seamark.bridge.rosbridge.conftest import Bridged, Open

EXAMPLE = Path(__file__).parents[4] / "examples" / "rosbridge" / "pi.py"
ONE_LEVEL = {"levels": [0.3]}


def _slowly(message: Any) -> float:
    time.sleep(0.01)
    return 0.0


def _surge(message: Any) -> float:
    return 0.4 * float(message["vector"]["x"])


def _finish(bridged: Bridged, running: Running) -> Any:
    outcome = running.outcome()
    bridged.bridge.publish_result("{}")
    return outcome


@pytest.mark.slow
def test_the_example_with_roslibpy_has_the_digest_of_the_built_in_pi(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start()
    address = ("127.0.0.1", str(bridged.bridge.port))

    program = subprocess.Popen([sys.executable, str(EXAMPLE), *address], stdout=subprocess.PIPE)
    outcome = running.outcome()
    bridged.bridge.publish_result("over")
    printed, _ = program.communicate(timeout=60)

    assert outcome.failure is None
    assert outcome.digest == built_in("pi").digest
    assert printed.decode() == "over\n"


@pytest.mark.slow
def test_a_program_has_the_same_digest_however_slowly_it_answers(open_bridge: Open) -> None:
    digests = set()
    for delay_s in (0.0, 0.01):
        bridged = open_bridge()
        running = bridged.start(**ONE_LEVEL)
        client = bridged.client()
        client.subscribe("/seamark/error")

        def answer(message: Any, delay_s: float = delay_s) -> float:
            time.sleep(delay_s)
            return _surge(message)

        thread = threading.Thread(target=client.answer_all, args=("/seamark/error", answer))
        thread.start()
        digests.add(_finish(bridged, running).digest)
        thread.join()

    assert len(digests) == 1
    assert digests != {built_in("nothing", **ONE_LEVEL).digest}


@pytest.mark.slow
def test_looking_at_every_topic_does_not_change_the_result(open_bridge: Open) -> None:
    digests = set()
    for topics in (["/seamark/error"], ["/seamark/image", "/seamark/pose", "/seamark/error"]):
        bridged = open_bridge()
        running = bridged.start(levels=[0.3], level_duration_s=2)
        client = bridged.client()
        for topic in topics:
            client.subscribe(topic)
        thread = threading.Thread(target=client.answer_all, args=("/seamark/error", _surge))
        thread.start()
        digests.add(_finish(bridged, running).digest)
        thread.join()
        assert len(client.others) == 40 * (len(topics) - 1)

    assert len(digests) == 1


def test_a_program_that_stops_answering_ends_with_a_sentence(open_bridge: Open) -> None:
    bridged = open_bridge(answer_within_s=0.3)
    running = bridged.start(**ONE_LEVEL)
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.send(op="publish", topic="/cmd_vel", msg={"linear": {"x": 1e9}})
    client.receive(op="publish")
    client.command(0.0)

    outcome = running.outcome()

    assert outcome.failure is FailureReason.TIME_LIMIT
    assert "within 0.3 s after the observation at t = 0.05 s" in outcome.sentence
    assert "Refused: /cmd_vel: linear.x" in outcome.sentence


def test_a_run_that_nobody_begins_ends_if_its_place_is_for_others_too(open_bridge: Open) -> None:
    bridged = open_bridge(first_answer_s=0.3)
    running = bridged.start(**ONE_LEVEL)
    bridged.client().subscribe("/seamark/error")

    outcome = running.outcome()

    assert outcome.failure is FailureReason.TIME_LIMIT
    assert "within 0.3 s after the observation at t = 0 s" in outcome.sentence


@pytest.mark.slow
def test_a_program_that_answers_each_observation_in_time_ends_when_its_time_is_over(
    open_bridge: Open,
) -> None:
    bridged = open_bridge(whole_s=0.5)
    running = bridged.start(levels=[0.3], level_duration_s=600)
    client = bridged.client()
    client.subscribe("/seamark/error")
    thread = threading.Thread(target=client.answer_all, args=("/seamark/error", _slowly))
    thread.start()
    outcome = _finish(bridged, running)
    thread.join()

    assert outcome.failure is FailureReason.TIME_LIMIT
    assert outcome.sentence.startswith("The run took 0.5 s, the most that a connection may last.")


def test_a_run_for_one_client_ends_when_that_leaves_before_it_has_begun(open_bridge: Open) -> None:
    bridged = open_bridge(one_client=True)
    running = bridged.start(**ONE_LEVEL)
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    client.socket.close()

    assert "The program disconnected" in running.outcome().sentence


def test_a_program_that_leaves_ends_with_the_time(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(**ONE_LEVEL)
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    client.command(0.0)
    client.receive(op="publish")
    client.socket.close()

    outcome = running.outcome()

    assert outcome.failure is FailureReason.USER_ERROR
    assert outcome.sentence == "The program disconnected at t = 0.05 s, before the run was over."


def test_two_references_for_one_observation_end_the_run(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(levels=[0.3], level_duration_s=600)
    client = bridged.client()
    client.subscribe("/seamark/error")

    def twice(message: Any) -> float:
        client.command(0.0)
        return 0.0

    thread = threading.Thread(target=client.answer_all, args=("/seamark/error", twice))
    thread.start()
    outcome = _finish(bridged, running)
    thread.join()

    assert outcome.failure is FailureReason.PROTOCOL_ERROR
    assert "--real-time" in outcome.sentence


def test_a_stamped_reference_answers_its_own_observation_only(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(**ONE_LEVEL)
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    client.command(0.0, ns=1)
    assert "is not that of the observation, 0 s" in client.receive(op="status")["msg"]
    client.command(0.0)  # t = 0 has no stamp that differs from an unset one
    client.receive(op="publish")
    client.command(0.0, ns=50_000_000)
    second = client.receive(op="publish")["msg"]["header"]["stamp"]
    client.command(0.0, ns=50_000_000)  # once more: too late
    client.receive(op="status")

    assert second == {"secs": 0, "nsecs": 100_000_000}
    client.socket.close()
    assert "disconnected at t = 0.1 s" in running.outcome().sentence


@pytest.mark.slow
def test_with_real_time_a_program_may_publish_by_its_own_clock(open_bridge: Open) -> None:
    bridged = open_bridge(real_time=True)
    running = bridged.start(levels=[0.3], level_duration_s=2)
    client = bridged.client()
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    began = time.monotonic()
    for _ in range(3):
        client.command(0.1)

    outcome = running.outcome()

    assert outcome.failure is None
    assert time.monotonic() - began > 1.9


@pytest.mark.parametrize("leave", [False, True])
def test_one_client_controls_and_others_watch(open_bridge: Open, leave: bool) -> None:
    bridged = open_bridge()
    running = bridged.start(**ONE_LEVEL)
    pilot, watcher = bridged.client(), bridged.client()
    pilot.send(op="advertise", topic="/cmd_vel", type="geometry_msgs/Twist")
    watcher.subscribe("/seamark/error")
    pilot.subscribe("/clock")
    pilot.receive(op="publish")

    watcher.command(0.0)
    refusal = watcher.receive(op="status")
    if leave:
        pilot.send(op="unadvertise", topic="/cmd_vel")
        pilot.subscribe("/clock", id="again")  # answered after the order before it
        pilot.send(op="call_service", service="/rosapi/topics", id=1)
        pilot.receive(op="service_response")
        watcher.command(0.0)
    else:
        pilot.command(0.0)

    assert refusal["level"] == "error"
    assert refusal["msg"].endswith("controls the vehicle already.")
    watcher.receive(op="publish", topic="/seamark/error")  # the one after the refusal
    (watcher if leave else pilot).socket.close()
    assert "disconnected at t = 0.05 s" in running.outcome().sentence
