"""The numbers of the protocol (docs/protocol.md), little endian: the same file on both ends."""

import struct

VERSION = 1
COMMAND = ("surge", "sway", "heave", "yaw_rate")  # [m/s, m/s, m/s, rad/s]
HEADER = struct.Struct("<cB2xI")  # type, version, sequence number
SIZES = struct.Struct("<II")  # [B] of the program's header, of the program
IMAGE = struct.Struct("<4I")  # offset [B], height, width [px], channels
CORNERS = struct.Struct("<8d")  # [px] x and y of the four corners
COUNT = struct.Struct("<I")  # of detections
DETECTION = struct.Struct("<9dH")  # corners, confidence, bytes of the label that follows
ERROR = struct.Struct("<cH")  # letter of the verdict, bytes of the sentence

MAX_MESSAGE_BYTES = 65536  # [B] the longest one is an error with its traceback
MAX_VALUE = 1e6  # [m/s, rad/s, px] a number beyond is a mistake
MAX_JOINTS = 16  # of an arm, whose speeds follow the first four numbers of a command
MAX_DETECTIONS = 64
MAX_LABEL_BYTES = 64


def command_names(layout: dict) -> tuple[str, ...]:  # type: ignore[type-arg]  # no import of typing
    """Return the numbers of a command: the vehicle's four, then each joint of its arm."""
    return tuple(layout.get("command", COMMAND))


def command_limits(layout: dict) -> tuple[float, ...]:  # type: ignore[type-arg]
    """Return the largest magnitude of each number of a command."""
    joints = tuple(map(float, layout.get("joint_limits", ())))
    return (MAX_VALUE,) * (len(command_names(layout)) - len(joints)) + joints
