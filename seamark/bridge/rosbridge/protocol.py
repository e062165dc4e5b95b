"""What clients send: the operations of the rosbridge v2 protocol that a bridge understands."""

from typing import Annotated, Any, Literal

import orjson
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from seamark.bridge.rosbridge.axes import Axes
from seamark.sandbox.languages.inside.wire import MAX_JOINTS, MAX_VALUE
from seamark.sim.engine.program import Command

NS = 1_000_000_000
LONGEST_MESSAGE = 64 * 1024  # [B] no operation below is longer
_LONGEST_NAME = 256
Name = Annotated[str, Field(min_length=1, max_length=_LONGEST_NAME)]
Value = Annotated[float, Field(ge=-MAX_VALUE, le=MAX_VALUE, allow_inf_nan=False)]
StatusLevel = Literal["info", "warning", "error", "none"]
LEVELS: tuple[StatusLevel, ...] = ("info", "warning", "error", "none")  # rising


class Refused(Exception):
    """A message that is not carried out; the text is for the program's author."""

    def __init__(self, text: str, *, reply_to: str | int | None = None) -> None:
        super().__init__(text)
        self.reply_to = reply_to


class _Operation(BaseModel):
    model_config = ConfigDict(frozen=True)

    id: Annotated[str, Field(max_length=_LONGEST_NAME)] | int | None = None


class Advertise(_Operation):
    """The client is going to publish on a topic."""

    op: Literal["advertise"]
    topic: Name
    type: Annotated[str, Field(max_length=_LONGEST_NAME)] = ""


class Unadvertise(_Operation):
    """The client is not going to publish on a topic any more."""

    op: Literal["unadvertise"]
    topic: Name


class Publish(_Operation):
    """A message on a topic."""

    op: Literal["publish"]
    topic: Name
    msg: dict[str, Any]


class Subscribe(_Operation):
    """The client wants the messages of a topic."""

    op: Literal["subscribe"]
    topic: Name
    type: Annotated[str, Field(max_length=_LONGEST_NAME)] = ""
    throttle_rate: Annotated[int, Field(ge=0, le=86_400_000)] = 0  # [ms] of simulated time
    compression: Annotated[str, Field(max_length=_LONGEST_NAME)] = "none"


class Unsubscribe(_Operation):
    """The client does not want them any more; without an id, of none of its subscriptions."""

    op: Literal["unsubscribe"]
    topic: Name


class CallService(_Operation):
    """A call of a service."""

    op: Literal["call_service"]
    service: Name
    args: dict[str, Any] | list[Any] = Field(default_factory=dict)


class SetLevel(_Operation):
    """From which level on the client gets status messages."""

    op: Literal["set_level"]
    level: StatusLevel


class SetAxes(_Operation):
    """In which axes the client speaks; an operation of Seamark, not of the protocol."""

    op: Literal["set_axes"] = "set_axes"
    axes: Axes


Operation = (
    Advertise | Unadvertise | Publish | Subscribe | Unsubscribe | CallService | SetLevel | SetAxes
)
_OPERATIONS = TypeAdapter[Operation](Annotated[Operation, Field(discriminator="op")])


class _Vector3(BaseModel):
    x: Value = 0.0
    y: Value = 0.0
    z: Value = 0.0


class _Twist(BaseModel):
    linear: _Vector3
    angular: _Vector3 = _Vector3()

    def command(self) -> Command:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        return self.linear.x, self.linear.y, self.linear.z, self.angular.z


class _Time(BaseModel):
    secs: Annotated[int, Field(ge=0, le=2**32)] = 0
    nsecs: Annotated[int, Field(ge=0, lt=NS)] = 0
    sec: Annotated[int, Field(ge=0, le=2**32)] = 0
    nanosec: Annotated[int, Field(ge=0, lt=NS)] = 0


class _Header(BaseModel):
    stamp: _Time = _Time()
    frame_id: Annotated[str, Field(max_length=_LONGEST_NAME)] = ""


class _TwistStamped(BaseModel):
    twist: _Twist
    header: _Header = _Header()

    def stamp_ns(self) -> int | None:
        """Return the simulated time that the reference answers [ns]; None if it is not set."""
        stamp = self.header.stamp
        return NS * (stamp.secs + stamp.sec) + stamp.nsecs + stamp.nanosec or None


def read(message: str | bytes) -> Operation:
    """Return the operation of a message.

    Raises
    ------
    Refused
        It is not JSON, or not an operation that a bridge understands.
    """
    if isinstance(message, bytes):
        raise Refused("Binary messages are not supported: send JSON.")
    try:
        value = orjson.loads(message)
    except orjson.JSONDecodeError as error:
        raise Refused(f"The message is not JSON: {error}.") from None
    if not isinstance(value, dict):
        raise Refused("A message must be a JSON object with `op`.")
    try:
        return _OPERATIONS.validate_python(value)
    except ValidationError as error:
        raise Refused(_sentence(error, value), reply_to=_id_of(value)) from None


def _id_of(value: dict[str, Any]) -> str | int | None:
    given = value.get("id")
    return given if isinstance(given, str | int) and len(str(given)) <= _LONGEST_NAME else None


def _sentence(error: ValidationError, value: dict[str, Any]) -> str:
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    if first["type"].startswith("union_tag"):
        op = str(value.get("op"))[:_LONGEST_NAME]
        return f"The operation {op!r} is not supported."
    where = ".".join(str(part) for part in first["loc"])
    return f"{where}: {first['msg']}."


def read_reference(publication: Publish, axes: Axes) -> tuple[Command, int | None]:
    """Return a velocity reference and the simulated time that it answers [ns], if it says so.

    The message is a Twist or a TwistStamped, whatever the topic was advertised as.

    Raises
    ------
    Refused
        It is neither, a number is not finite or too large, or it names the frame of other axes.
    """
    message = publication.msg
    try:
        if "twist" in message:
            stamped = _TwistStamped.model_validate(message)
            _check_frame(publication, stamped.header.frame_id, axes)
            return axes.command(stamped.twist.command()), stamped.stamp_ns()
        return axes.command(_Twist.model_validate(message).command()), None
    except ValidationError as error:
        text = f"{publication.topic}: {_sentence(error, message)}"
        raise Refused(text, reply_to=publication.id) from None


class _Speeds(BaseModel):
    data: Annotated[list[Value], Field(max_length=MAX_JOINTS)]


def read_joint_speeds(publication: Publish, joints: int) -> Command:
    """Return the speeds of so many joints [rad/s or m/s].

    Raises
    ------
    Refused
        They are others, or a number is not finite or too large.
    """
    try:
        speeds = tuple(_Speeds.model_validate(publication.msg).data)
    except ValidationError as error:
        text = f"{publication.topic}: {_sentence(error, publication.msg)}"
        raise Refused(text, reply_to=publication.id) from None
    if len(speeds) != joints:
        arm = f"The arm has {joints} joints with a motor" if joints else "The vehicle has no arm"
        text = f"{publication.topic}: {arm}; data has {len(speeds)} numbers."
        raise Refused(text, reply_to=publication.id)
    return speeds


def _check_frame(publication: Publish, frame: str, axes: Axes) -> None:
    """Raise Refused if sway, heave and yaw would have the wrong sign."""
    if frame.removeprefix("/") == axes.other.body:
        raise Refused(
            f"{publication.topic}: the reference is in {axes.other.body}, but this program speaks "
            f"{axes.body}. Start the bridge with --axes {axes.other}; on a server, connect with "
            f"axes={axes.other}.",
            reply_to=publication.id,
        )
