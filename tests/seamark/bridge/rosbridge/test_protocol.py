"""Operations of rosbridge: what is understood, and what is refused without ending the run."""

import base64
from typing import Any

import numpy as np
import orjson
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.protocol import Publish, Refused, read, read_reference
from seamark.bridge.rosbridge.server import MOST_CLIENTS
from seamark.bridge.rosbridge.topics import REFERENCES, TOPICS
from seamark.sim.control.observation import SONAR
from tests.seamark.bridge.rosbridge.conftest import WITH_ARM, Open

REFUSED: list[tuple[str | bytes, str]] = [
    ("{", "not JSON"),
    ("[" * 60_000, "not JSON"),
    ('{"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": NaN}}}', "not JSON"),
    ("[]", "must be a JSON object"),
    (b"\x00", "Binary messages"),
    ("{}", "is not supported"),
    ('{"op": 3}', "is not supported"),
    ('{"op": "fragment", "id": "1", "data": "", "num": 0, "total": 2}', "'fragment' is not"),
    ('{"op": "advertise_service", "service": "/x", "type": "y"}', "'advertise_service'"),
    ('{"op": "subscribe"}', "subscribe.topic: Field required"),
    ('{"op": "subscribe", "topic": "/clock", "throttle_rate": -1}', "throttle_rate"),
    ('{"op": "publish", "topic": "/cmd_vel", "msg": []}', "publish.msg"),
]


@pytest.mark.parametrize(("message", "reason"), REFUSED, ids=range(len(REFUSED)))
def test_what_is_no_operation_is_refused_with_its_reason(message: str | bytes, reason: str) -> None:
    with pytest.raises(Refused, match=reason):
        read(message)


@pytest.mark.parametrize(
    "message",
    [
        {},
        {"linear": {"x": 1e7}},
        {"linear": {"x": "fast"}},
        {"linear": {"x": None}},
        {"twist": {}},
        {"twist": {"linear": {}}, "header": {"stamp": {"secs": -1}}},
    ],
)
def test_what_is_no_velocity_is_refused(message: dict[str, Any]) -> None:
    with pytest.raises(Refused, match="/cmd_vel"):
        read_reference(Publish(op="publish", topic="/cmd_vel", msg=message), Axes.NED)


def test_a_reference_keeps_every_bit_and_unset_fields_are_zero() -> None:
    twist = {"linear": {"x": 0.1 + 0.2, "y": -5e-324}, "angular": {"z": 1 / 3}}
    for message in (twist, {"twist": twist}):
        text = orjson.dumps({"op": "publish", "topic": "cmd_vel", "msg": message}).decode()
        publication = read(text)
        assert isinstance(publication, Publish)
        assert read_reference(publication, Axes.NED) == ((0.1 + 0.2, -5e-324, 0.0, 1 / 3), None)


def test_a_refused_message_is_answered_and_the_run_goes_on(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(levels=[0.3])
    client = bridged.client()
    for message, reason in REFUSED:
        client.socket.send(message)
        assert reason in client.receive(op="status", level="error")["msg"]
    client.send(op="subscribe", topic="/no/such", id="a")
    assert client.receive(op="status", id="a")["msg"] == "There is no topic /no/such."
    client.subscribe("/clock", "std_msgs/Bool")
    assert "rosgraph_msgs/Clock, not std_msgs/Bool" in client.receive(op="status")["msg"]
    client.send(op="advertise", topic="/other", type="std_msgs/Bool")
    client.receive(op="status")
    client.send(op="set_level", level="none")
    client.subscribe("/no/such")

    client.subscribe("/clock")
    client.receive(op="publish", topic="/clock")
    client.command(0.0)
    client.receive(op="publish", topic="/clock")
    assert client.others == []
    client.socket.close()
    running.outcome()


def test_one_who_sends_too_much_at_once_is_disconnected_alone(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(levels=[0.3])
    loud, quiet = bridged.client(), bridged.client()
    loud.socket.send("x" * 100_000)

    with pytest.raises(ConnectionClosed):
        loud.receive(op="status")

    quiet.subscribe("/clock")
    quiet.receive(op="publish")
    quiet.command(0.0)
    quiet.receive(op="publish")
    quiet.socket.close()
    assert "disconnected at t = 0.05 s" in running.outcome().sentence


def test_a_page_of_the_web_cannot_connect(open_bridge: Open) -> None:
    bridged = open_bridge()

    with pytest.raises(InvalidStatus, match="403"):
        bridged.client(origin="https://example.org")

    assert bridged.client(origin="http://localhost:3000")


def test_there_is_a_limit_on_clients(open_bridge: Open) -> None:
    bridged = open_bridge()
    clients = [bridged.client() for _ in range(MOST_CLIENTS)]
    for client in clients:
        client.send(op="call_service", service="/rosapi/topics")
        client.receive(op="service_response")

    with pytest.raises(ConnectionClosed):
        bridged.client().receive(op="status")


@pytest.mark.parametrize(
    ("separator", "seconds", "rest"), [("/", "secs", "nsecs"), ("/msg/", "sec", "nanosec")]
)
def test_the_type_of_a_subscription_chooses_the_version_of_ros(
    open_bridge: Open, separator: str, seconds: str, rest: str
) -> None:
    bridged = open_bridge(joints=5)
    running = bridged.start(**WITH_ARM, images="both")
    client = bridged.client()

    heard = {name: topic for name, topic in TOPICS.items() if topic.camera != SONAR}
    assert len(heard) == len(TOPICS) - 2

    for name, topic in heard.items():
        client.subscribe(name.removeprefix("/"), f"{topic.package}{separator}{topic.kind}")
        message = client.receive(op="publish")
        assert message["topic"] == name.removeprefix("/")  # as the client wrote it
        stamp = message["msg"].get("header", {}).get("stamp", {seconds: 0, rest: 0})
        assert stamp == {seconds: 0, rest: 0}
    assert client.others == []  # nothing came twice
    client.command(0.0)
    client.socket.close()
    running.outcome()


def test_an_image_is_what_the_camera_sees(open_bridge: Open) -> None:
    bridged = open_bridge()
    running = bridged.start(levels=[0.3])
    client = bridged.client()
    client.subscribe("/seamark/image", "sensor_msgs/Image")
    message = client.receive(op="publish")["msg"]
    pixels = np.frombuffer(base64.b64decode(message["data"]), np.uint8)
    client.command(0.0)
    client.socket.close()
    running.outcome()

    assert (message["encoding"], message["step"]) == ("rgb8", 3 * message["width"])
    rgb = pixels.reshape(message["height"], message["width"], 3)
    assert rgb[..., 2].mean() > rgb[..., 0].mean()  # water: more blue than red


def test_a_throttled_topic_comes_at_simulated_intervals_until_it_is_unsubscribed(
    open_bridge: Open,
) -> None:
    bridged = open_bridge()
    running = bridged.start(levels=[0.3])
    client = bridged.client()
    client.subscribe("/clock", throttle_rate=100)
    client.subscribe("/seamark/error", id="x")
    for step in range(8):
        client.receive(topic="/seamark/error")
        if step == 5:
            client.send(op="unsubscribe", topic="/clock")
        client.command(0.0)
    client.socket.close()
    running.outcome()

    times = [message["msg"]["clock"]["nsecs"] // 10**6 for message in client.others]
    assert times == [0, 100, 200]


def test_the_services_of_rosapi_list_the_topics(open_bridge: Open) -> None:
    client = open_bridge().client()

    def call(service: str, **args: str) -> Any:
        client.send(op="call_service", service=service, args=args, id="i")
        return client.receive(op="service_response", id="i")

    names = call("/rosapi/topics")["values"]["topics"]
    assert {*TOPICS, *REFERENCES} < set(names)
    assert call("/rosapi/topic_type", topic="/clock")["values"] == {"type": "rosgraph_msgs/Clock"}
    assert (
        "/clock" in call("/rosapi/topics_for_type", type="rosgraph_msgs/Clock")["values"]["topics"]
    )
    assert call("/rosapi/nodes")["result"] is False
