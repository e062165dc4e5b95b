"""The mechanisms of the tests in MuJoCo and PyBullet: the same links, motors, shapes and pairs.

Neither knows added mass as a matrix, so only rigid masses go over; weight in water becomes a share
of gravity.
"""

from math import sqrt
from tempfile import NamedTemporaryFile
from xml.etree import ElementTree

import mujoco
import numpy as np
import pybullet

from seamark.sim.multibody.mechanism import Link, Mechanism, Shape
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import STANDARD_GRAVITY
from tests.sim.multibody.scenes import GROUND

# As MuJoCo's documentation advises for grasping: friction without slip.
MUJOCO_OPTIONS = {"cone": "elliptic", "impratio": "10", "noslip_iterations": "5"}
_MOTOR_GAIN = "1000"  # [N m s/rad or N s/m]


def _words(values: object) -> str:
    return " ".join(f"{value:.17g}" for value in np.ravel(np.asarray(values, dtype=float)))


def _body(link: Link) -> tuple[float, Array, Array]:
    """Return mass, centre (3,) and inertia about it (3, 3) of a link's rigid part."""
    mass = float(link.rigid[0, 0])
    x, y, z = link.rigid[2, 4], link.rigid[0, 5], link.rigid[1, 3]
    centre = -np.array([x, y, z]) / mass
    skew = np.array(
        [[0.0, -centre[2], centre[1]], [centre[2], 0.0, -centre[0]], [-centre[1], centre[0], 0.0]]
    )
    return mass, centre, link.rigid[3:, 3:] - mass * skew.T @ skew


class MuJoCo:
    """A mechanism in MuJoCo."""

    def __init__(self, mechanism: Mechanism, step_s: float, options: dict[str, str]) -> None:
        """Compile it; speeds of motors are zero."""
        root = ElementTree.Element("mujoco")
        settings = {"timestep": f"{step_s:g}", "gravity": f"0 0 {STANDARD_GRAVITY}"}
        settings |= {"integrator": "implicitfast", **options}
        ElementTree.SubElement(root, "option", settings)
        ElementTree.SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
        world = ElementTree.SubElement(root, "worldbody")
        bodies: dict[str | None, ElementTree.Element] = {None: world}
        for link in mechanism.links:
            bodies[link.name] = _add_body(mechanism, link, bodies[link.parent])
        for shape in mechanism.shapes:
            _add_geom(shape, bodies[shape.link])
        contact = ElementTree.SubElement(root, "contact")
        by_name = {shape.name: shape for shape in mechanism.shapes}
        for one, other in mechanism.pairs:
            friction = np.sqrt(by_name[one].friction * by_name[other].friction)
            ElementTree.SubElement(
                contact,
                "pair",
                geom1=one,
                geom2=other,
                condim="3",
                friction=_words([friction, friction, 0.0, 0.0, 0.0]),
            )
        equality = ElementTree.SubElement(root, "equality")
        for tie in mechanism.couplings:
            ElementTree.SubElement(
                equality,
                "joint",
                joint1=tie.link,
                joint2=tie.other,
                polycoef=_words([0.0, tie.ratio, 0.0, 0.0, 0.0]),
            )
        actuator = ElementTree.SubElement(root, "actuator")
        for motor in mechanism.motors:
            ElementTree.SubElement(
                actuator,
                "velocity",
                joint=motor.link,
                kv=_MOTOR_GAIN,
                forcerange=_words([-motor.effort, motor.effort]),
            )
        self.model = mujoco.MjModel.from_xml_string(ElementTree.tostring(root, "unicode"))
        self.data = mujoco.MjData(self.model)

    def run(self, steps: int) -> None:
        """Move on."""
        mujoco.mj_step(self.model, self.data, steps)

    def accelerations(self) -> Array:
        """Return the accelerations now, without a step."""
        mujoco.mj_forward(self.model, self.data)
        rates: Array = self.data.qacc.copy()
        return rates


def _add_body(mechanism: Mechanism, link: Link, parent: ElementTree.Element) -> ElementTree.Element:
    mass, centre, inertia = _body(link)
    share = 1.0 - link.net_weight / (mass * STANDARD_GRAVITY)
    x, y, _z = np.array(link.turn).T
    body = ElementTree.SubElement(
        parent,
        "body",
        name=link.name,
        pos=_words(link.offset),
        xyaxes=_words([x, y]),
        gravcomp=f"{share:.17g}",
    )
    ElementTree.SubElement(
        body,
        "inertial",
        mass=f"{mass:.17g}",
        pos=_words(centre),
        fullinertia=_words(
            [
                inertia[0, 0],
                inertia[1, 1],
                inertia[2, 2],
                inertia[0, 1],
                inertia[0, 2],
                inertia[1, 2],
            ]
        ),
    )
    if link.joint == "free":
        ElementTree.SubElement(body, "freejoint", name=link.name)
        return body
    stops = [limit for limit in mechanism.limits if limit.link == link.name]
    kept = [part for part in mechanism.frictions if part.link == link.name]
    joint = {
        "name": link.name,
        "type": "hinge" if link.joint == "revolute" else "slide",
        "axis": _words(link.axis),
        "frictionloss": _words([kept[0].resting if kept else 0.0]),
        "armature": _words([link.rotor]),
    }
    if stops:
        joint |= {"range": _words([stops[0].low, stops[0].high]), "limited": "true"}
    ElementTree.SubElement(body, "joint", joint)
    return body


def _add_geom(shape: Shape, body: ElementTree.Element) -> None:
    radius, half, depth = shape.size
    x, y, z = np.array(shape.turn).T
    axes = {"pos": _words(shape.place), "contype": "0", "conaffinity": "0", "mass": "0"}
    if shape.kind == "ground":
        axes |= {"type": "plane", "size": "50 50 1", "xyaxes": "1 0 0 0 -1 0"}
        axes["pos"] = f"0 0 {GROUND.depth:g}"
    elif shape.kind == "box":
        axes |= {"type": "box", "size": _words([radius, half, depth]), "xyaxes": _words([x, y])}
    elif shape.kind == "capsule" and half > 0.0:
        axes |= {"type": "capsule", "size": _words([radius, half]), "xyaxes": _words([y, z])}
    else:
        axes |= {"type": "sphere", "size": _words([radius])}
    ElementTree.SubElement(body, "geom", {"name": shape.name, **axes})


class PyBullet:
    """A mechanism in PyBullet, with one gravity [m/s²] for everything and no coupled joints."""

    def __init__(
        self, mechanism: Mechanism, step_s: float, gravity: float, poses: dict[str, Array]
    ) -> None:
        """Load it; free links start at `poses`, (3,)."""
        self.world = pybullet.connect(pybullet.DIRECT)
        here = {"physicsClientId": self.world}
        pybullet.setTimeStep(step_s, **here)
        pybullet.setGravity(0.0, 0.0, gravity, **here)
        # With the 50 iterations that are its default the bar is lost.
        pybullet.setPhysicsEngineParameter(numSolverIterations=200, **here)
        self.bodies: dict[str, int] = {}
        roots: list[Link | None] = [link for link in mechanism.links if link.parent is None]
        if any(shape.link is None for shape in mechanism.shapes):
            roots.append(None)
        for root in roots:
            with NamedTemporaryFile("w", suffix=".urdf") as file:
                file.write(_urdf(mechanism, root))
                file.flush()
                free = root is not None and root.joint == "free"
                body = pybullet.loadURDF(
                    file.name,
                    poses.get(root.name if root else "", np.zeros(3)),
                    useFixedBase=not free,
                    flags=pybullet.URDF_USE_INERTIA_FROM_FILE,
                    **here,
                )
            self.bodies[root.name if root else ""] = body
            for at in range(-1, pybullet.getNumJoints(body, **here)):
                pybullet.changeDynamics(
                    body,
                    at,
                    linearDamping=0.0,
                    angularDamping=0.0,
                    jointDamping=0.0,
                    lateralFriction=_friction(mechanism),
                    **here,
                )
                if at >= 0:
                    pybullet.setJointMotorControl2(
                        body, at, pybullet.VELOCITY_CONTROL, force=0.0, **here
                    )
        for kept in mechanism.frictions:
            self.drive(kept.link, 0.0, kept.resting)

    def drive(self, link: str, speed: float, effort: float) -> None:
        """Drive the joint of a root link at a speed with at most this effort."""
        pybullet.setJointMotorControl2(
            self.bodies[link],
            0,
            pybullet.VELOCITY_CONTROL,
            targetVelocity=speed,
            force=effort,
            physicsClientId=self.world,
        )

    def run(self, steps: int, push: tuple[str, Array] | None = None) -> None:
        """Move on; `push` is a force on a free link [N]."""
        for _ in range(steps):
            if push is not None:
                body = self.bodies[push[0]]
                where, _turn = pybullet.getBasePositionAndOrientation(
                    body, physicsClientId=self.world
                )
                pybullet.applyExternalForce(
                    body, -1, push[1], where, pybullet.WORLD_FRAME, physicsClientId=self.world
                )
            pybullet.stepSimulation(physicsClientId=self.world)

    def position(self, link: str) -> Array:
        """Return where a free link is, (3,) [m]."""
        pose = pybullet.getBasePositionAndOrientation(self.bodies[link], physicsClientId=self.world)
        return np.array(pose[0])

    def coordinate(self, link: str) -> float:
        """Return the coordinate of a root link's joint."""
        state = pybullet.getJointState(self.bodies[link], 0, physicsClientId=self.world)
        return float(state[0])

    def close(self) -> None:
        """Forget it."""
        pybullet.disconnect(self.world)


def _friction(mechanism: Mechanism) -> float:
    """Return the friction that Bullet multiplies with another one to that of the scene."""
    return sqrt(max(shape.friction for shape in mechanism.shapes))


def _urdf(mechanism: Mechanism, root: Link | None) -> str:
    """Return a link that hangs on nothing, or the shapes of the world."""
    robot = ElementTree.Element("robot", name="part")
    if root is None or root.joint != "free":
        base = ElementTree.SubElement(robot, "link", name="base")
        _add_inertia(base, 1.0, np.zeros(3), np.eye(3))
        if root is None:
            for shape in mechanism.shapes:
                if shape.link is None:
                    _add_collision(shape, base)
            return ElementTree.tostring(robot, "unicode")
    body = ElementTree.SubElement(robot, "link", name=root.name)
    _add_inertia(body, *_body(root))
    for shape in mechanism.shapes:
        if shape.link == root.name:
            _add_collision(shape, body)
    if root.joint != "free":
        kind = "continuous" if root.joint == "revolute" else "prismatic"
        joint = ElementTree.SubElement(robot, "joint", name=root.name, type=kind)
        ElementTree.SubElement(joint, "parent", link="base")
        ElementTree.SubElement(joint, "child", link=root.name)
        ElementTree.SubElement(joint, "origin", xyz=_words(root.offset))
        ElementTree.SubElement(joint, "axis", xyz=_words(root.axis))
        ElementTree.SubElement(
            joint, "limit", lower="-10", upper="10", effort="1000", velocity="100"
        )
    return ElementTree.tostring(robot, "unicode")


def _add_inertia(body: ElementTree.Element, mass: float, centre: Array, inertia: Array) -> None:
    inertial = ElementTree.SubElement(body, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_words(centre))
    ElementTree.SubElement(inertial, "mass", value=f"{mass:.17g}")
    names = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2)}
    names["iyz"] = (1, 2)
    numbers = {name: f"{inertia[at]:.17g}" for name, at in names.items()}
    ElementTree.SubElement(inertial, "inertia", numbers)


def _add_collision(shape: Shape, body: ElementTree.Element) -> None:
    """Add a box, sphere or capsule along an axis of its link; the ground is a large box."""
    collision = ElementTree.SubElement(body, "collision")
    geometry = ElementTree.SubElement(collision, "geometry")
    radius, half, _depth = shape.size
    place, turn = shape.place, "0 0 0"
    if shape.kind == "ground":
        place = (0.0, 0.0, GROUND.depth + 5.0)
        ElementTree.SubElement(geometry, "box", size="100 100 10")
    elif shape.kind == "box":
        ElementTree.SubElement(geometry, "box", size=_words(2.0 * np.array(shape.size)))
    elif half > 0.0:
        ElementTree.SubElement(geometry, "capsule", radius=f"{radius:g}", length=f"{2 * half:g}")
        turn = f"0 {0.5 * np.pi:.17g} 0"  # along x
    else:
        ElementTree.SubElement(geometry, "sphere", radius=f"{radius:g}")
    ElementTree.SubElement(collision, "origin", xyz=_words(place), rpy=turn)
