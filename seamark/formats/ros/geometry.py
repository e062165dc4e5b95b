"""Vectors, poses and transforms as messages of geometry_msgs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from seamark.formats.ros import frames

Message = dict[str, Any]
Stamp = dict[str, int]


def header(stamp: Stamp, frame: str) -> Message:
    """Return a std_msgs/Header."""
    return {"stamp": stamp, "frame_id": frame}


def xyz(vector: Iterable[float]) -> Message:
    """Return a vector or a point."""
    return dict(zip("xyz", vector, strict=True))


def xyzw(quaternion: Iterable[float]) -> Message:
    """Return a quaternion."""
    return dict(zip("xyzw", quaternion, strict=True))


def pose(position: Iterable[float], rotation: Iterable[float]) -> Message:
    """Return a geometry_msgs/Pose."""
    return {"position": xyz(position), "orientation": xyzw(rotation)}


def pose_stamped(position: Iterable[float], rotation: Iterable[float], stamp: Stamp) -> Message:
    """Return a geometry_msgs/PoseStamped in the world frame."""
    return {"header": header(stamp, frames.MAP), "pose": pose(position, rotation)}


def transform(
    parent: str,
    child: str,
    stamp: Stamp,
    position: Iterable[float],
    rotation: Iterable[float],
) -> Message:
    """Return a geometry_msgs/TransformStamped; `rotation` is x, y, z, w."""
    return {
        "header": header(stamp, parent),
        "child_frame_id": child,
        "transform": {"translation": xyz(position), "rotation": xyzw(rotation)},
    }


def twist(linear: Iterable[float], angular: Iterable[float]) -> Message:
    """Return a geometry_msgs/Twist."""
    return {"linear": xyz(linear), "angular": xyz(angular)}
