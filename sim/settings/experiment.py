"""Settings of every benchmark: vehicle, timing, start of a level.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from collections.abc import Mapping
from functools import partial
from importlib.util import find_spec

from seamark.sim.recording.telemetry import COMMON_THRUSTERS, thrust_names, width_for
from seamark.sim.registry import TRUTH, VEHICLES
from seamark.sim.settings.control_loop import ControlLoopSettings
from seamark.sim.settings.scene import SceneSettings
from seamark.sim.settings.setting import setting
from seamark.sim.settings.targets import TARGETS, TargetShape
from seamark.sim.settings.thruster_faults import FaultSettings
from seamark.sim.sonar.device import Device
from seamark.sim.vehicles import is_known, load, most_thrusters, own
from seamark.sim.vehicles.linkage import Linkage

experiment_setting = partial(setting, group="Experiment", role="scenario")

SMALLEST_SIDE_PX = 16.0  # [px] a tracker cannot be initialised on a smaller target
OWN_VEHICLE = (
    " A vehicle of your own is chosen by its file: seamark run or seamark submit BENCHMARK --set "
    "vehicle=FILE.toml, or the form of a run."
)
START_ERROR_SHARE = 0.1  # of the shorter side: the corners remain a convex quadrilateral


class ExperimentSettings(ControlLoopSettings, SceneSettings, FaultSettings):
    """A vehicle with a camera above the target, level after level."""

    vehicle: str = experiment_setting(
        "girona500",
        title="Vehicle",
        help="Vehicle model, sets its own defaults.",
        choices={name: load(name).title for name in VEHICLES},
    )
    level_duration_s: float = experiment_setting(
        120.0,
        title="Level duration",
        help="Simulated time before the vehicle is reset and the current increases.",
        unit="s",
        low=2,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    control_period_s: float = experiment_setting(
        0.05,
        title="Control period",
        help="Time between two images, and between two steps of the controller.",
        unit="s",
        low=0.01,
        high=0.5,
        tag="E",
        source="20 images per second; the original's tracker waits 40 ms for each",
        advanced=True,
    )
    physics_step_s: float = experiment_setting(
        0.01,
        title="Physics step",
        help="Step of the integrator (fourth-order Runge-Kutta).",
        unit="s",
        low=0.001,
        high=0.02,
        tag="D",
        source="within 1e-6 mm of the limit after 600 s",
        advanced=True,
    )
    altitude_m: float = experiment_setting(
        2.27,
        title="Camera altitude",
        help="Height of the camera above the top of the target at the start of a level.",
        unit="m",
        low=0.8,
        high=6,
        tag="D",
        source="uwsimbenchmarks 988deda, dynamicsTrackingScene.xml: poses of camera and box",
    )
    contact: bool = experiment_setting(
        True,
        title="Collisions",
        help="Whether the vehicle can collide with the seabed and the target, which does not move.",
        advanced=True,
    )
    contacts: str = experiment_setting(
        "seamark",
        title="Contact engine",
        help="Computes collisions: the simulator's own engine, or PyBullet to compare with (on "
        "Python 3.11 alone; its last bits depend on the processor).",
        choices={"seamark": "Seamark", "pybullet": "PyBullet"},
        advanced=True,
    )
    seabed_relief_m: float = experiment_setting(
        0.0,
        title="Seabed relief",
        help="Maximum height of random (seeded) mounds for hull, DVL and altimeter; 0: flat. "
        "Camera images show a flat seabed regardless.",
        unit="m",
        low=0,
        high=1,
        tag="E",
        source="an option: the published scene is flat",
        advanced=True,
    )
    seabed_flat_radius_m: float = experiment_setting(
        2.0,
        title="Flat area around the target",
        help="Radius without mounds. With 2 m the images at the station are correct, and the DVL's "
        "beams hit no mound there.",
        unit="m",
        low=0.5,
        high=10,
        tag="E",
        source="what the camera sees from the station",
        advanced=True,
    )
    start_error_px: float = experiment_setting(
        0.0,
        title="Initial tracker error",
        help="Standard deviation of the corners with which the tracker is initialised.",
        unit="px",
        low=0,
        high=10,
        advanced=True,
    )

    @classmethod
    def accepts(cls, name: str, value: object) -> bool:
        """Return whether a value is also the vehicle of a user that this process has read."""
        vehicle = name == own.SETTING and own.is_own(value) and is_known(value)
        return vehicle or super().accepts(name, value)

    @classmethod
    def hint(cls, name: str, value: object) -> str:
        """Return where a vehicle's file can be used."""
        if name != own.SETTING or not isinstance(value, str):
            return super().hint(name, value)
        return OWN_VEHICLE if value.endswith(own.SUFFIX) or own.is_own(value) else ""

    @classmethod
    def preset(cls, name: str, value: object) -> Mapping[str, object]:
        """Return the defaults of a user's own vehicle, as far as this benchmark has them."""
        if not cls.accepts(name, value):
            return {}
        defaults = load(str(value)).defaults
        return {key: default for key, default in defaults.items() if key in cls.settings()}

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        if not multiple(self.control_period_s, self.physics_step_s):
            errors["control_period_s"] = (
                f"control_period_s (Control period) must be a whole multiple of the physics step "
                f"of {self.physics_step_s:g} s, not {self.control_period_s:g} s."
            )
        if not multiple(self.level_duration_s, self.control_period_s):
            errors["level_duration_s"] = (
                f"level_duration_s (Level duration) must be a whole multiple of the control "
                f"period of {self.control_period_s:g} s, not {self.level_duration_s:g} s."
            )
        if not multiple(1.0 / self.dvl_rate_hz, self.physics_step_s):
            errors["dvl_rate_hz"] = (
                f"dvl_rate_hz (DVL rate) must have a period that is a whole multiple of the "
                f"physics step of {self.physics_step_s:g} s, such as 5 or 20 Hz, "
                f"not {self.dvl_rate_hz:g} Hz."
            )
        if self.contact_engine() == "pybullet" and find_spec("pybullet") is None:
            errors["contacts"] = (
                "contacts (Contact engine): PyBullet is not installed. It needs Python 3.11 and "
                "`pip install seamark[pybullet]`; the simulator's own engine needs nothing."
            )
        return errors | self._fault_errors() | self._image_errors() | super().cross_field_errors()

    def chosen_arm(self) -> Linkage | None:
        """Return the vehicle's arm, if there is one: none, unless overridden."""
        return None

    def target_shape(self) -> TargetShape:
        """Return the box that the camera looks at: the chosen one, unless overridden."""
        return TARGETS[self.target]

    def camera_mount_m(self) -> tuple[float, float, float] | None:
        """Return where the vehicle's camera is on the body [m]; None: as in UWSim."""
        return None

    def has_workpiece(self) -> bool:
        """Return whether the arm works on something that telemetry follows."""
        return False

    def searches(self) -> bool:
        """Return whether what the arm works on has to be found first."""
        return False

    def sonar_device(self) -> Device | None:
        """Return the imaging sonar of the vehicle; none unless overridden."""
        return None

    def has_route(self) -> bool:
        """Return whether there is a route to follow."""
        return False

    def has_dock(self) -> bool:
        """Return whether there is a dock to enter."""
        return False

    def told(self) -> dict[str, bool]:
        """Return which further groups of fields an observation has; see `control.observation`."""
        return {"search": self.searches(), "route": self.has_route(), "dock": self.has_dock()}

    def vehicles(self) -> tuple[str, ...]:
        """Return the vehicles that take turns from trial to trial: one, unless overridden."""
        return (self.vehicle,)

    def _fault_errors(self) -> dict[str, str]:
        count = min(len(load(name).thrusters) for name in self.vehicles())
        errors: dict[str, str] = {}
        if self.fault_thruster >= count:
            errors["fault_thruster"] = (
                f"fault_thruster (Faulty thruster) must be from -1 to {count - 1}: this vehicle "
                f"has {count} thrusters."
            )
        if self.fault_delay_s and not multiple(self.fault_delay_s, self.control_period_s):
            errors["fault_delay_s"] = (
                f"fault_delay_s (Thruster delay) must be a whole multiple of the control period of "
                f"{self.control_period_s:g} s, not {self.fault_delay_s:g} s."
            )
        return errors

    def _image_errors(self) -> dict[str, str]:
        """Return setting -> message for images in which no tracker could start."""
        errors: dict[str, str] = {}
        box = self.target_shape()
        long, short = (
            side * self.camera_focal_px / self.altitude_m for side in (box.length_m, box.width_m)
        )
        highest = box.width_m * self.camera_focal_px / SMALLEST_SIDE_PX
        if short < SMALLEST_SIDE_PX:
            errors["altitude_m"] = (
                f"altitude_m (Camera altitude) must be at most {highest:.2f} m with this "
                f"focal length, not {self.altitude_m:g} m: the target would be too small."
            )
        if long > self.camera_width_px or short > self.camera_height_px:
            errors["camera_focal_px"] = (
                f"camera_focal_px (Focal length) makes the target {long:.0f} x {short:.0f} px; it "
                f"must fit into {self.camera_width_px} x {self.camera_height_px} px."
            )
        if self.camera_exposure_s > self.control_period_s:
            errors["camera_exposure_s"] = (
                f"camera_exposure_s (Exposure time) must be at most the control period of "
                f"{self.control_period_s:g} s, not {self.camera_exposure_s:g} s."
            )
        if self.start_error_px > START_ERROR_SHARE * short:
            errors["start_error_px"] = (
                f"start_error_px (Initial tracker error) must be at most "
                f"{START_ERROR_SHARE * short:.1f} px, a tenth of the target's shorter side, "
                f"not {self.start_error_px:g} px."
            )
        return errors

    def exact(self) -> bool:
        """Return whether every processor gives the same bits."""
        return super().exact() and self.contact_engine() != "pybullet"

    def contact_engine(self) -> str:
        """Return what computes contacts, or "off"."""
        return self.contacts if self.contact else "off"

    def ranking_errors(self) -> dict[str, str]:
        """Return setting -> message for what a ranked run does not allow."""
        if self.tracker == TRUTH:
            return {"tracker": "tracker (Tracker) must not be the ground truth in a ranked run."}
        return {}

    def unused_columns(self) -> frozenset[str]:
        """Return the thrust columns that the vehicle does not use, and the contact force if off."""
        # A stored run may name one that no longer exists.
        known = [name for name in self.vehicles() if is_known(name)]
        count = max((len(load(name).thrusters) for name in known), default=COMMON_THRUSTERS)
        idle = set(thrust_names(max(most_thrusters(), COMMON_THRUSTERS))[count:])
        return frozenset(idle if self.contact else idle | {"contact_n"})

    def trial_duration_s(self) -> float:
        """Return the simulated duration of all levels together."""
        return len(self.level_values()) * self.level_duration_s

    def telemetry_shape(self) -> tuple[int, int]:
        """Return how many rows a trial has, one per control step, and how many columns."""
        thrusters = max(len(load(name).thrusters) for name in self.vehicles())
        rows = len(self.level_values()) * self.control_steps_per_level
        return rows, self.telemetry_width(thrusters)

    def telemetry_width(self, thrusters: int) -> int:
        """Return how many columns a row has for a vehicle with this number of thrusters."""
        arm, work, search = self.chosen_arm() is not None, self.has_workpiece(), self.searches()
        alone = {"route": self.has_route(), "dock": self.has_dock()}
        return width_for(thrusters, arm=arm, work=work, search=search, **alone)

    @property
    def physics_steps_per_control_step(self) -> int:
        """Physics steps in one control period."""
        return round(self.control_period_s / self.physics_step_s)

    @property
    def dvl_period_steps(self) -> int:
        """Physics steps per DVL measurement."""
        return round(1.0 / (self.dvl_rate_hz * self.physics_step_s))

    @property
    def control_steps_per_level(self) -> int:
        """Control steps in one level."""
        return round(self.level_duration_s / self.control_period_s)


def multiple(whole: float, part: float) -> bool:
    """Return whether `whole` is an integer multiple of `part`."""
    count = whole / part
    return round(count) >= 1 and abs(count - round(count)) < 1e-6
