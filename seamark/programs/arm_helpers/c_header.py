"""Kinematics of the arms in C, for C++ as well."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from seamark.programs.arm_helpers.known_arms import KnownArms
from seamark.sim.control.manipulation.arm_data import ArmData, Place

NAME = "arm.h"
_NUMBERS = "/* NUMBERS */"


def text(known: KnownArms) -> str:
    """Return the header."""
    template = Path(__file__).with_name(NAME).read_text("utf-8")
    return template.replace(_NUMBERS, "\n".join(_numbers(known)))


def _numbers(known: KnownArms) -> Iterator[str]:
    yield "static const arm_data arm_known[] = {"
    for name, arm in known.arms.items():
        yield f'    {{"{name}", {len(arm.motors)}, {len(arm.chain)}, {_place(arm.tool)},'
        yield from _arm(arm)
    yield "};"
    yield ""
    yield "static const struct {"
    yield "    const char *vehicle, *arm;"
    yield "    arm_place place; /* of the arm's base in the body */"
    yield "} arm_mounts[] = {"
    for (vehicle, name), place in known.mounts.items():
        yield f'    {{"{vehicle}", "{name}", {_place(place)}}},'
    yield "};"


def _arm(arm: ArmData) -> Iterator[str]:
    motors = [
        f'{{"{each.name}", {each.low}, {each.high}, {each.fastest}, {each.home}}}'
        for each in arm.motors
    ]
    chain = [
        f'{{"{each.name}", {_place(each.place)}, {_vector(each.axis)}, {each.motor}}}'
        for each in arm.chain
    ]
    yield f"     {{{(',' + chr(10) + ' ' * 6).join(motors)}}},"
    yield f"     {{{(',' + chr(10) + ' ' * 6).join(chain)}}}}},"


def _place(place: Place) -> str:
    return f"{{{_vector(place[0])}, {_vector(place[1])}}}"


def _vector(values: Iterable[float]) -> str:
    return f"{{{', '.join(map(str, values))}}}"
