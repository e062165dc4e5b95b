"""Kinematics of the arms in MATLAB."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from seamark.programs.arm_helpers.known_arms import KnownArms
from seamark.sim.control.manipulation.arm_data import ArmData, Place

NAME = "arm_kinematics.m"
_NUMBERS = "% NUMBERS\n"


def text(known: KnownArms) -> str:
    """Return the file of a function."""
    template = Path(__file__).with_name(NAME).read_text("utf-8")
    return template.replace(_NUMBERS, "".join(f"{line}\n" for line in _numbers(known)))


def _numbers(known: KnownArms) -> Iterator[str]:
    yield "function arm = numbers_of(name)"
    yield "    switch name"
    for name, arm in known.arms.items():
        yield f"        case '{name}'"
        yield from (f"            {line}" for line in _arm(arm))
    yield "        otherwise"
    yield "            error('There is no arm %s.', name);"
    yield "    end"
    yield "end"
    yield ""
    yield "function mount = mount_of(vehicle, name)"
    yield "    switch [vehicle, ' ', name]"
    for (vehicle, name), place in known.mounts.items():
        yield f"        case '{vehicle} {name}'"
        yield f"            mount = [{_numbers_of(place)}];"
    yield "        otherwise"
    yield "            error('%s carries no %s.', vehicle, name);"
    yield "    end"
    yield "end"


def _arm(arm: ArmData) -> Iterator[str]:
    names = ", ".join(f"'{motor.name}'" for motor in arm.motors)
    yield f"arm.names = {{{names}}};"
    for field, name in (("low", "low"), ("high", "high"), ("fastest", "fastest"), ("home", "home")):
        values = "; ".join(str(getattr(motor, field)) for motor in arm.motors)
        yield f"arm.{name} = [{values}];"
    yield "arm.chain = [ ..."
    for link in arm.chain:
        numbers = f"{_numbers_of(link.place)}, {_row(link.axis)}, {link.motor + 1}"
        yield f"    {numbers}; ...  % {link.name}"
    yield "];"
    yield f"arm.tool = [{_numbers_of(arm.tool)}];"


def _numbers_of(place: Place) -> str:
    return f"{_row(place[0])}, {_row(place[1])}"


def _row(values: Iterable[float]) -> str:
    return ", ".join(map(str, values))
