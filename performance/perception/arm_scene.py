"""A BlueROV2 with an arm above a black box, as its camera and the one on its forearm see it."""

from typing import NamedTuple

import numpy as np

from seamark.sim.camera import Effects, Optics, Water
from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.link_camera import LinkCamera
from seamark.sim.multibody import tree
from seamark.sim.multibody.assembly import VEHICLE, Frame, Mounting, assemble
from seamark.sim.multibody.tree import frames_for
from seamark.sim.vehicles import Quantity, load
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.sim.vehicles.model import Place

_ARM = "alpha-like"
_SEABED_M = 5.0
_DEPTH_M = 4.2  # of the vehicle
_JOINTS = {"upper arm": 0.4, "forearm": 2.7}  # [rad] so that the jaws reach for the handle
_THINGS = {  # name -> place, pitch and yaw
    "black-box": (0.66, 0.03, 4.9, 0.0, 0.35),
    "bar": (0.75, 0.35, 4.99, 0.0, 0.3),
    "peg": (0.75, -0.3, 4.985, 0.0, 1.0),
    "valve": (1.3, -0.4, 4.8, 0.0, -0.4),
}
_OPTICS = Optics(width=320, height=240, focal_px=200.0)
# Place [m], pitch and yaw [rad]: on a bracket beside the arm, which they look along.
_EYE = (0.12, 0.2, -0.2, -0.75, -0.38)
_LAMP = (0.0, -0.2, -0.2, -0.65, 0.25)


class ArmScene(NamedTuple):
    """Where everything is, and what is drawn."""

    wrist: Frame  # where the arm has its camera
    placed: Placed
    bodies: Bodies


def arm_scene(*, own_hull: bool = False) -> ArmScene:
    """Return the scene, with or without the hull of the vehicle."""
    vehicle = load("bluerov2-heavy-v2")
    mountings = [
        Mounting(linkage=load_linkage(_ARM), place=vehicle.mounts[_ARM], on_vehicle=True),
        *(Mounting(linkage=load_linkage(name), place=_at(*there), prefix=f"{name} ")
          for name, there in _THINGS.items()),
    ]  # fmt: skip
    assembly = assemble(vehicle, mountings)
    model = assembly.mechanism.model(0.002)
    state = assembly.state(model)
    state.q[2] = _DEPTH_M
    for name, angle in _JOINTS.items():
        state.q[assembly.coordinate(model, name)] = angle
    links = [link.name for link in assembly.mechanism.links]
    frames = frames_for(len(links), len(state.v))
    tree.place(model.structure, model.links, state.q, frames)
    twist = np.zeros((len(links), 6))
    hull = len(vehicle.drawn())
    looks = assembly.looks if own_hull else assembly.looks[hull:]
    if assembly.camera is None:
        raise ValueError(f"{_ARM} has no camera")
    return ArmScene(
        assembly.camera, Placed(frames.rotation, frames.position, twist), Bodies(looks, links)
    )


def cameras(
    scene: ArmScene, water: Water, *, effects: Effects | None = None, empty: bool = False
) -> tuple[LinkCamera, LinkCamera]:
    """Return the camera of the vehicle and the one on its arm, with the lamp of the vehicle."""
    bodies = Bodies((), scene.bodies.links) if empty else scene.bodies
    vehicle = Frame(VEHICLE, np.zeros(3), np.eye(3))
    first, second = (
        LinkCamera(
            _OPTICS,
            water,
            bodies,
            mount=mount,
            seabed_m=_SEABED_M,
            noise_seed=1,
            lamp=vehicle.inner(_at(*_LAMP)),
            effects=effects,
        )
        for mount in (vehicle.inner(_at(*_EYE)), scene.wrist)
    )
    return first, second


def _at(x: float, y: float, z: float, pitch: float, yaw: float = 0.0) -> Place:
    def given(meaning: str, unit: str, *value: float) -> Quantity:
        return Quantity(meaning=meaning, value=value, unit=unit, tag="E", source="the scene")

    return Place(point=given("place", "m", x, y, z), turn=given("turn", "rad", 0.0, pitch, yaw))
