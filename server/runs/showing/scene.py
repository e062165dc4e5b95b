"""What stands in the water of a run: vehicle, target, seabed and turbidity of a level.

The same objects as the vehicle's camera shows, for a view from outside. Lengths in m, world frame
north, east, down; body frame forward, starboard, down.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from seamark.formats.jpeg import jpeg
from seamark.server.programs import own_files
from seamark.server.runs.data import stored_files
from seamark.server.runs.showing import camera_view
from seamark.server.runs.showing.routes import route_of
from seamark.server.runs.showing.searches import search_of
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.vehicles import Vehicle, is_known, load
from seamark.sim.vehicles.linkage import Linkage, LinkData
from seamark.sim.vehicles.model import Place
from seamark.sim.vehicles.solids import Solid

if TYPE_CHECKING:
    from seamark.sim.camera.bottom.painter import Tiles
    from seamark.sim.camera.camera import Camera
    from seamark.sim.multibody.assembly import Mounting
    from seamark.sim.multibody.workpiece import Workpiece

TEXTURE_PX = 512  # side of the seabed's picture; a texel of it is 1 cm
Part = Literal["seabed", "target", "decoy"]
Surface = NDArray[np.uint8]


class NoDecoy(Exception):
    """There is nothing that looks like the target."""


def has_level(run: RunView, trial: int, level: int) -> bool:
    """Return whether the run has this trial and level."""
    levels = registry.benchmark(run.benchmark).restore(run.config).level_values()
    return trial < run.trials and level < len(levels)


def is_held_back(settings: Settings, run: RunView, trial: int) -> bool:
    """Return whether nobody may know the conditions of a trial yet: a fresh one without a row."""
    protocol = registry.benchmark(run.benchmark).protocol
    if run.seed is not None or protocol is None or trial < protocol.reference_trials:
        return False
    files = stored_files.of_run(settings, run)
    first, after = (files.rows_until(number, -np.inf) for number in (trial, trial + 1))
    return first == after


def describe(settings: Settings, run: RunView, *, trial: int, level: int) -> dict[str, Any]:
    """Return vehicle, target, camera and water of a level, and what an arm works on, if it does.

    The vehicle is null if the camera moves alone, or if it was the user's own and is deleted. The
    target is null above a painted bottom, which is another one in each level, if nothing but what
    is painted there is looked for. Where an arm's work has to be found first, `search` says how;
    where a route is followed, `route` is it.
    """
    config: Any = registry.benchmark(run.benchmark).restore(run.config)
    with camera_view.camera_of(settings, run, trial=trial, level=level) as camera:
        target, optics, water = camera.target, camera.optics, camera.water
        effects, ground = camera.effects, camera.ground
        work, painted = _workpiece(camera), _painted(camera) is not None
        places = _path(camera, config, level)
    from seamark.sim.camera.effects import LAMP_FORWARD_M  # noqa: PLC0415 - loads compiled code

    name = getattr(config.for_trial(trial), "vehicle", None)  # a camera may move without one
    with own_files.lent_to(settings, run):
        known = load(str(name)) if is_known(name) else None
        shape = None if known is None else vehicle_shape(known, config.chosen_arm())
        search = search_of(settings, run, target, optics, trial=trial, level=level)
        route = route_of(settings, run, trial=trial, level=level)
    return {
        "vehicle": shape,
        "target": None
        if painted and work is None
        else {
            "centre": target.origin().tolist(),
            "size": target.size_m,
            "heading": target.heading_rad,
            **({} if places is None else {"path": places}),
        },
        "seabed": {"depth": target.seabed_m, "ground": ground, "tile": _tile_m()}
        | ({"painted": True} if painted else {}),
        "camera": {
            "mount": optics.mount_m,
            "focal": optics.focal_px,
            "width": optics.width,
            "height": optics.height,
        },
        "water": {"law": water.law, "attenuation": water.attenuation, "veil": water.veil},
        "light": {
            "level": effects.light_level,
            "lamp": effects.lamp,
            "cone": effects.lamp_cone_rad,
            "forward": LAMP_FORWARD_M,
        },
        **({} if work is None else {"workpiece": work_shape(work)}),
        **({} if search is None else {"search": search}),
        **({} if route is None else {"route": route}),
    }


def vehicle_shape(vehicle: Vehicle, arm: Linkage | None = None) -> dict[str, Any]:
    """Return hull, thrusters, looks and arm of a vehicle as JSON."""
    return {
        "name": vehicle.name,
        "title": vehicle.title,
        "hull": [
            {"name": box.name, "centre": box.centre.value, "size": box.size.value}
            for box in vehicle.hull
        ],
        "thrusters": [
            {"name": one.name, "position": one.position.value, "direction": one.direction}
            for one in vehicle.thrusters
        ],
        "thrust_max": max(vehicle.curve.limits.value),
        "solids": _solids(vehicle.drawn()),
        "nozzle_radius": vehicle.nozzle_radius_m,
        "arm": None if arm is None else _arm_shape(arm, vehicle.mounts[arm.name]),
    }


def _solids(solids: Iterable[Solid]) -> list[dict[str, Any]]:
    return [
        {
            "shape": one.shape,
            "size": one.size,
            "centre": one.centre,
            "colour": one.paint.colour,
            "livery": one.paint.livery,
        }
        | ({"lettered": True} if one.lettered else {})
        for one in solids
    ]


def _arm_shape(arm: Linkage, mount: Place) -> dict[str, Any]:
    """Return the links of an arm, parents first, and how each moves with the columns of joints."""
    names, motors = [link.name for link in arm.links], arm.motors()
    sensor, feelers = arm.force_sensor, arm.outer
    return {
        **_place(mount),
        "links": [
            {
                "parent": None if link.parent is None else names.index(link.parent),
                **_place(link.joint.place),
                "joint": _joint(link, motors),
                "solids": _solids(link.solids),
                "touch": [feelers.index(each.name) for each in link.shapes if each.name in feelers],
            }
            for link in arm.links
        ],
        "force_sensor": sensor and {"link": names.index(sensor.link), **_place(sensor.place)},
    }


def _path(camera: "Camera", config: Any, level: int) -> dict[str, Any] | None:
    """Return where a target that moves by itself is in each image of a level: `places`.

    Each is north, east [m] and heading [rad]; `start` is the time of the first one in the trial and
    `period` that between two [s].
    """
    from seamark.sim.camera.moving_target import OWN, MovingTargetCamera  # noqa: PLC0415 - compiled

    if not isinstance(camera, MovingTargetCamera):
        return None
    images, period_s = config.control_steps_per_level, config.control_period_s
    vehicle, first = np.zeros(OWN), level * images
    return {
        "start": first * period_s,
        "period": period_s,
        "places": [
            camera.at(vehicle, first + image)[OWN : OWN + 3].round(5).tolist()
            for image in range(images)
        ],
    }


def _workpiece(camera: "Camera") -> "Workpiece | None":
    """Return what the arm of the vehicle with this camera works on, or the dock that it enters."""
    from seamark.sim.camera.arm_camera import ArmCamera  # noqa: PLC0415 - loads compiled code
    from seamark.sim.camera.standing_camera import StandingCamera  # noqa: PLC0415 - likewise

    return camera.workpiece if isinstance(camera, ArmCamera | StandingCamera) else None


def work_shape(work: "Workpiece") -> dict[str, Any]:
    """Return the things, of which the columns of the workpiece move one, and the face of that.

    Those of the decoy move another one, where there is one. `face` is in the axes of a link of a
    thing, or of the world: corners as one reads its letters.
    """
    numbers = {
        f"{thing.prefix}{link.name}": (number, index)
        for number, thing in enumerate(work.things)
        for index, link in enumerate(thing.linkage.links)
    }
    link = work.face.link
    return {
        "things": [_thing_shape(thing, work) for thing in work.things],
        "face": {
            "link": None if link is None else numbers[link],
            "corners": work.corners().tolist(),
        },
    }


def _thing_shape(thing: "Mounting", work: "Workpiece") -> dict[str, Any]:
    names = [link.name for link in thing.linkage.links]
    return {
        **_place(thing.place),
        "links": [
            {
                "parent": None if link.parent is None else names.index(link.parent),
                **_place(link.joint.place),
                "joint": _decoy_joint(link, thing, work) or _work_joint(link, thing, work.link),
                "solids": _solids(link.solids),
            }
            for link in thing.linkage.links
        ],
    }


def _decoy_joint(link: LinkData, thing: "Mounting", work: "Workpiece") -> dict[str, Any] | None:
    """Return how a link moves with the columns of the decoy; None if it does not."""
    is_decoy = f"{thing.prefix}{link.name}" in work.others
    return {"kind": "free", "of": "decoy"} if is_decoy else None


def _work_joint(link: LinkData, thing: "Mounting", followed: str) -> dict[str, Any] | None:
    """Return how a link moves with the columns of the workpiece; None if it stands."""
    joint = link.joint
    leader, ratio = joint.follows or (link.name, 1.0)
    if f"{thing.prefix}{leader}" != followed:
        return None
    free = joint.kind == "free"
    return {"kind": joint.kind} | ({} if free else {"axis": joint.axis, "ratio": ratio})


def _place(place: Place) -> dict[str, Any]:
    return {"place": place.point.value, "turn": place.turn.value}


def _joint(link: LinkData, motors: Sequence[str]) -> dict[str, Any] | None:
    """Return kind, axis, and the number of the motor whose coordinate times the ratio it has."""
    joint = link.joint
    leader, ratio = joint.follows or (link.name, 1.0)
    if leader not in motors:
        return None
    moved = {"column": motors.index(leader), "ratio": ratio}
    return {"kind": joint.kind, "axis": joint.axis, **moved}


def texture(settings: Settings, run: RunView, *, trial: int, level: int, part: Part) -> bytes:
    """Return the seabed's tile, columns to the north and rows to the east, or the target's top.

    A painted bottom is its tile with all that lies on it.

    With a workpiece, that is what cameras see on the upper side of its box with letters. The
    decoy's is that of the box that looks like it.

    Raises
    ------
    NoDecoy
        Nothing looks like the target.
    """
    with camera_view.camera_of(settings, run, trial=trial, level=level) as camera:
        if part != "seabed":
            work = _workpiece(camera)
            lettered = [] if work is None else _lettered(work, of_decoy=part == "decoy")
            if lettered:
                return jpeg(_letters_on(lettered[0]))
            if part == "decoy":
                raise NoDecoy("Nothing looks like the target of this run.")
            return jpeg(_top_of(camera.target))
        ground, tiles = camera.ground, _painted(camera)
    return _seabed(ground) if tiles is None else jpeg(np.dstack([*tiles[::-1]]))


def _tile_m() -> float:
    from seamark.sim.camera.seabed import TEXEL_M, TILE  # noqa: PLC0415 - loads compiled code

    return TILE * TEXEL_M


@lru_cache(maxsize=8)
def _seabed(ground: str) -> bytes:
    import cv2  # noqa: PLC0415 - loads OpenCV

    from seamark.sim.camera import pictures, seabed  # noqa: PLC0415 - loads OpenCV
    from seamark.sim.camera.camera import SAND  # noqa: PLC0415 - loads OpenCV

    if ground == SAND:
        planes = [seabed.texels(seabed.SEABED_SEED, channel) for channel in (2, 1, 0)]
    else:
        planes = [pictures.tile(ground)] * 3
    small = cv2.resize(np.dstack(planes), (TEXTURE_PX, TEXTURE_PX), interpolation=cv2.INTER_AREA)
    return jpeg(small.astype(np.uint8))


def _painted(camera: "Camera") -> "Tiles | None":
    """Return the seabed that is painted below this camera."""
    from seamark.sim.camera.arm_camera import ArmCamera  # noqa: PLC0415 - loads compiled code
    from seamark.sim.camera.bottom.camera import BottomCamera  # noqa: PLC0415 - loads OpenCV

    if isinstance(camera, BottomCamera):
        return camera.bottom.tiles
    return camera.bottom if isinstance(camera, ArmCamera) else None


def _lettered(work: "Workpiece", *, of_decoy: bool) -> list[Solid]:
    """Return the solids with letters, of the box that looks like it or of all other things."""
    return [
        solid
        for thing in work.things
        for link in thing.linkage.links
        if (f"{thing.prefix}{link.name}" in work.others) == of_decoy
        for solid in link.solids
        if solid.lettered
    ]


def _letters_on(solid: Solid) -> Surface:
    from seamark.sim.camera.bodies import UPPER, lettered_face  # noqa: PLC0415 - loads OpenCV
    from seamark.sim.camera.seabed import quantise  # noqa: PLC0415 - loads compiled code

    return np.dstack([quantise(lettered_face(solid, channel, UPPER)) for channel in (2, 1, 0)])


def _top_of(target: Any) -> Surface:
    from seamark.sim.camera.target import box_texture  # noqa: PLC0415 - loads OpenCV

    planes = []
    for channel in (2, 1, 0):
        texture = box_texture(target, channel)
        _, columns, rows = texture.layout[0]
        packed = texture.texels[: rows * columns]
        planes.append((packed & 0xFF).astype(np.uint8).reshape(rows, columns))
    return np.dstack(planes)
