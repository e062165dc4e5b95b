"""A gripper takes the peg of the registry by its handle, puts it into the socket and lets go."""

import numpy as np
import pytest

from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.mechanism import Coupling, Link, Motor, Shape
from seamark.sim.vehicles import Quantity
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.model import Place
from tests.sim.multibody.test_contacts import Scene, solid

DEPTH_M = 5.0
START_M = -0.25  # [m] of the peg's middle before the mouth
HANDLE_M = -0.09  # [m] before the peg's middle
DEEP_M = 0.08  # [m] the hole


def at(x: float, z: float) -> Place:
    point, turn = (
        Quantity(meaning="place", value=value, unit=unit, tag="E", source="a test")
        for value, unit in (((x, 0.0, z), "m"), ((0.0, 0.0, 0.0), "rad"))
    )
    return Place(point=point, turn=turn)


def gripper(sideways: float) -> tuple[Scene, int]:
    """A slide along x with two jaws around the handle, each of two fingers, and its first joint."""
    things = [("peg", START_M, DEPTH_M + sideways), ("socket", 0.0, DEPTH_M)]
    mounts = [Mounting(linkage=load_linkage(name), place=at(x, z)) for name, x, z in things]
    assembly = assemble(None, mounts, bottom=False)
    mechanism = assembly.mechanism
    mechanism.links.append(
        Link(
            name="slide",
            joint="prismatic",
            offset=(START_M + HANDLE_M, 0.0, DEPTH_M + sideways),
            axis=(1.0, 0.0, 0.0),
            rigid=solid(3.0, (0.1, 0.1, 0.1)),
        )
    )
    for jaw, side in (("upper", -1.0), ("lower", 1.0)):
        mechanism.links.append(
            Link(
                name=jaw,
                parent="slide",
                joint="prismatic",
                offset=(0.0, 0.0, side * 0.0185),
                axis=(0.0, 0.0, -side),
                rigid=solid(0.2, (0.06, 0.1, 0.01)),
                rotor=1.0,
            )
        )
        for finger, y in (("port", -0.04), ("starboard", 0.04)):
            name = f"{jaw} {finger}"
            size = (0.008, 0.02, 0.0)
            place = (0.0, y, 0.0)
            mechanism.shapes.append(
                Shape(name=name, kind="capsule", link=jaw, place=place, size=size, friction=0.9)
            )
            mechanism.pairs += [(name, "handle"), (name, "peg"), (name, "panel")]
    mechanism.motors = [Motor(link="slide", effort=60.0), Motor(link="upper", effort=80.0)]
    mechanism.couplings = [Coupling(link="lower", other="upper", ratio=1.0)]
    scene = Scene(mechanism, iterations=20)
    scene.state.q[:] = assembly.state(scene.model).q
    return scene, assembly.coordinate(scene.model, "slide")


@pytest.mark.parametrize("sideways", [0.0, 0.002])
def test_a_peg_is_taken_by_its_handle_put_into_the_socket_and_left_there(sideways: float) -> None:
    scene, slide = gripper(sideways)
    scene.command.speed[:] = 0.0, 0.05
    scene.run(500)
    held = scene.state.q[:3].copy()
    scene.run(500)
    creep = np.abs(scene.state.q[:3] - held).max()

    scene.command.speed[0] = 0.05
    scene.run(round((-START_M - 0.01) / 0.05 / 0.002))
    inserted = float(scene.state.q[0])
    scene.command.speed[:] = 0.0, -0.05
    scene.run(250)
    scene.command.speed[:] = -0.1, 0.0
    scene.run(1000)

    assert creep < 1e-3
    assert inserted + DEEP_M == pytest.approx(0.07, abs=0.004)
    assert scene.state.q[slide] < 0.06
    assert float(scene.state.q[0]) == pytest.approx(inserted, abs=0.002)
    assert np.abs(scene.state.v).max() < 0.11  # only the slide moves


def test_jaws_do_not_pass_through_the_panel() -> None:
    scene, slide = gripper(0.1)  # beside the peg, which falls
    scene.command.speed[:] = 0.1, 0.0

    scene.run(3000)

    face = -START_M - HANDLE_M
    assert scene.state.q[slide] == pytest.approx(face - 0.028, abs=1e-3)
