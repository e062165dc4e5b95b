"""Settings of an arm: which one the vehicle carries, its sensors, and images for the program."""

from functools import partial

from seamark.sim.control.observation import ARM_CAMERA, VEHICLE_CAMERA
from seamark.sim.recording.telemetry import ARM_COLUMNS, ARM_FEELERS, ARM_JOINTS
from seamark.sim.registry import ARMS
from seamark.sim.settings.current import CurrentSettings
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.setting import setting
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage

GROUP = "Arm"
NO_ARM = "none"
CAMERAS = {  # value of the setting -> cameras whose images a program is given
    "none": (),
    "vehicle": (VEHICLE_CAMERA,),
    "arm": (ARM_CAMERA,),
    "both": (VEHICLE_CAMERA, ARM_CAMERA),
}
_OF_JOINTS = ("joint", "joint_speed", "joint_ref", "joint_effort")
arm_setting = partial(setting, group=GROUP, role="scenario")


class ArmSettings(ExperimentSettings, CurrentSettings):
    """A vehicle that may carry an arm."""

    arm: str = arm_setting(
        NO_ARM,
        title="Arm",
        help="Arm on the vehicle, whose joints the program moves. It can touch the seabed, the "
        "target and the vehicle.",
        choices={NO_ARM: "None"} | {name: load_linkage(name).title for name in ARMS},
    )
    arm_noise: float = arm_setting(
        1.0,
        title="Noise of the arm's sensors",
        help="Multiplies the noise of encoders, motor currents and force sensor.",
        low=0,
        high=100,
        advanced=True,
    )
    images: str = arm_setting(
        "none",
        title="Images for the program",
        help="Which cameras' grey images a controller is given, ten times a second; they are as "
        "late as those of the tracker.",
        choices={
            "none": "None",
            "vehicle": "Camera of the vehicle",
            "arm": "Camera on the arm",
            "both": "Both cameras",
        },
    )

    def chosen_arm(self) -> Linkage | None:
        """Return the arm, if there is one; a stored run may name one that no longer exists."""
        return load_linkage(self.arm) if self.arm in ARMS else None

    def cameras_of_program(self) -> tuple[str, ...]:
        """Return the cameras whose images a controller is given."""
        return CAMERAS.get(self.images, ())  # a stored run may have another value

    def unused_columns(self) -> frozenset[str]:
        """Return the columns of the arm too that it does not use."""
        arm = self.chosen_arm()
        if arm is None:
            return super().unused_columns() | {column.name for column in ARM_COLUMNS}
        motors = range(len(arm.motors()), ARM_JOINTS)
        names = {f"{name}_{at}" for name in _OF_JOINTS for at in motors}
        feelers = range(len(arm.outer), ARM_FEELERS)
        return super().unused_columns() | names | {f"touch_{at}" for at in feelers}

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        arm = self.chosen_arm()
        if ARM_CAMERA in self.cameras_of_program() and (arm is None or arm.camera is None):
            errors["images"] = (
                "images (Images for the program): there is no camera on an arm. Choose an arm that "
                "has one, or the camera of the vehicle alone."
            )
        if arm is None:
            return errors | super().cross_field_errors()
        without = [name for name in self.vehicles() if arm.name not in load(name).mounts]
        if without:
            errors["arm"] = (
                f"arm (Arm): {load(without[0]).title} has no place for {arm.title}. Choose another "
                "arm or vehicle; a vehicle of your own says in its file where an arm sits."
            )
        if self.contact_engine() == "pybullet":
            errors["contacts"] = (
                "contacts (Contact engine): with an arm, choose the simulator's own engine."
            )
        if self.fish_per_min:
            errors["fish_per_min"] = (
                "fish_per_min (Fish): with an arm, there are no fish before the camera; write 0."
            )
        if self.current_law == "force":
            errors["current_law"] = (
                "current_law (Current model): with an arm, choose the relative velocity of the "
                "water; the body force acts on a vehicle alone."
            )
        return errors | super().cross_field_errors()
