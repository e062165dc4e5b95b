"""Kinematics of the arms in Python: the text of the simulator's own, and their numbers."""

import ast
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from seamark.programs.arm_helpers.known_arms import KnownArms
from seamark.sim.control.manipulation.arm_data import ArmData

NAME = "arm.py"
_PACKAGE = "seamark.sim.control.manipulation"
_HEAD = '''\
"""Kinematics of the arms of Seamark: forward, its Jacobian, and inverse, in plain Python.

`seamark init` wrote this file. You may use, modify and distribute it freely; it comes without any
warranty. Keep it in one folder with your program, and upload the folder as an archive:

    from arm import arm_of, damped

    arm = arm_of(config)  # in __init__: the arm of the run
    joints = observation.joints.tolist()  # [rad] of all motors: the joints, then the jaws
    tool = arm.tool(joints)  # tool.point: tool centre point [m]; tool.turn: its axes as columns
    joints = arm.inverse((1.4, 0.0, 0.8), joints)  # None if there are none
    tool, columns = arm.jacobian(joints)  # of each joint: velocity of the point, and axis
    ways = [columns[motor][0] for motor in arm.reaching]
    speeds = damped(ways, (0.0, 0.0, 0.05), 0.05)  # [rad/s] that lower the tool by 5 cm/s

The base frame is that of the vehicle's body: origin as its file has it, x forward, y starboard,
z down. p = R q + t takes a point of the inner axes to the outer ones. Lengths in m, angles in rad.
ARMS and MOUNTS at the end are the numbers: ranges, speeds, and every link from mount to tool.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

'''
_TAIL = '''

def sincos(angle: float) -> tuple[float, float]:
    """Return sine and cosine."""
    return math.sin(angle), math.cos(angle)


def arm_of(config: Mapping[str, object]) -> ArmKinematics:
    """Return the kinematics of the arm of a run, given the configuration of the program."""
    vehicle, arm = str(config["vehicle"]), str(config["arm"])
    return ArmKinematics(ARMS[arm], MOUNTS[vehicle, arm])
'''


def text(known: KnownArms) -> str:
    """Return the module."""
    parts = [_HEAD, _body("arm_data"), "\n\n", _body("kinematics"), _TAIL, "\n", "\n"]
    return "".join(parts) + "\n".join(_numbers(known)) + "\n"


def _body(module: str) -> str:
    """Return the text of a module behind its imports, which is read and not loaded."""
    spec = find_spec(f"{_PACKAGE}.{module}")
    if spec is None or spec.origin is None:
        raise FileNotFoundError(module)
    source = Path(spec.origin).read_text("utf-8")
    imports = [
        node.end_lineno or 0
        for node in ast.parse(source).body
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    return "\n".join(source.splitlines()[max(imports) :]).strip("\n") + "\n"


def _numbers(known: KnownArms) -> Iterator[str]:
    yield "ARMS = {"
    for name, arm in known.arms.items():
        yield f'    "{name}": ArmData('
        yield from _arm(arm)
        yield "    ),"
    yield "}"
    yield "MOUNTS = {  # of the arm's base in the body of a vehicle"
    for (vehicle, name), place in known.mounts.items():
        yield f'    ("{vehicle}", "{name}"): {place},'
    yield "}"


def _arm(arm: ArmData) -> Iterator[str]:
    yield "        motors=("
    for motor in arm.motors:
        numbers = (f"{key}={value}" for key, value in motor._asdict().items() if key != "name")
        yield f'            Motor("{motor.name}", {", ".join(numbers)}),'
    yield "        ),"
    yield "        chain=(  # name; place and turn in the link before; axis; number of its motor"
    for link in arm.chain:
        yield f'            Link("{link.name}", {link.place}, {link.axis}, {link.motor}),'
    yield "        ),"
    yield f"        tool={arm.tool},"
