"""Settings of the scene: water, camera, target and sensors.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.settings.image_effects import EffectSettings
from seamark.sim.settings.setting import setting
from seamark.sim.settings.targets import TARGETS

water_setting = partial(setting, group="Water and camera", role="scenario")
sensor_setting = partial(setting, group="Sensors", role="scenario")
WATER_TYPES = {
    "grey": "Grey (the same attenuation for every colour)",
    "I": "Jerlov I (clearest ocean)",
    "IB": "Jerlov IB (clear ocean)",
    "II": "Jerlov II (ocean)",
    "III": "Jerlov III (turbid ocean)",
    "1C": "Jerlov 1C (clear coast)",
    "3C": "Jerlov 3C (coast)",
    "5C": "Jerlov 5C (turbid coast)",
    "7C": "Jerlov 7C (harbour)",
    "9C": "Jerlov 9C (turbid harbour)",
}


class SceneSettings(EffectSettings):
    """Water, camera, target and sensors."""

    target: str = water_setting(
        "lettered",
        title="Target",
        help="The box on the seabed that the camera looks at. A plain one only has edges: give the "
        "template tracker a margin of 6 px.",
        choices={name: shape.label for name, shape in TARGETS.items()},
        tag="S",
        source="black box of this size: benchmark_software_launcher ea65b39; the others are ours",
        advanced=True,
    )

    water_law: str = water_setting(
        "beer",
        title="Water model",
        help="How contrast decays with distance.",
        choices={"beer": "Beer-Lambert attenuation", "uwsim": "UWSim fog"},
    )
    water_type: str = water_setting(
        "IB",
        title="Water type",
        help="Attenuation per colour channel.",
        choices=WATER_TYPES,
        tag="S",
        source="attenuation by Williamson & Hollins 2022 and Solonenko & Mobley 2015",
    )
    water_attenuation_1_m: float = water_setting(
        0.2,
        title="Attenuation",
        help="Grey water only: beam attenuation, or the density of the fog.",
        unit="1/m",
        low=0,
        high=10,
    )
    camera_noise_grey: float = water_setting(
        1.2,
        title="Camera noise",
        help="Standard deviation of the read noise in grey levels (0 to 255); below 0.8, rounding "
        "to whole grey levels would decide which tracker fails.",
        unit="grey",
        low=0.8,
        high=64,
        tag="E",
        source="UWSim's 0.005 of full scale is 1.3 grey levels",
        advanced=True,
    )
    camera_width_px: int = water_setting(
        640,
        title="Image width",
        help="Width of the camera image.",
        unit="px",
        low=160,
        high=1280,
        tag="S",
        source="uwsimbenchmarks 988deda, dynamicsTrackingScene.xml",
        advanced=True,
    )
    camera_height_px: int = water_setting(
        480,
        title="Image height",
        help="Height of the camera image.",
        unit="px",
        low=120,
        high=960,
        tag="S",
        source="uwsimbenchmarks 988deda, dynamicsTrackingScene.xml",
        advanced=True,
    )
    camera_focal_px: float = water_setting(
        514.7,
        title="Focal length",
        help="Focal length of the camera.",
        unit="px",
        low=50,
        high=5000,
        tag="S",
        source="uwsimbenchmarks 988deda, dynamicsTrackingScene.xml: 50° vertical field of view",
        advanced=True,
    )
    target_truth: str = water_setting(
        "centroid",
        title="Target reference point",
        help="The point that defines the true position of the target in the image.",
        choices={
            "centroid": "Centre of the top face",
            "uwsim": "Projected origin of the object (the paper)",
        },
        advanced=True,
    )

    dvl_rate_hz: float = sensor_setting(
        5.0,
        title="DVL rate",
        help="Measurements per second.",
        unit="Hz",
        low=0.5,
        high=20,
        tag="S",
        source="UWSim DVLSensor and COLA2; Stonefish has 20 Hz",
        advanced=True,
    )
    dvl_sigma_m_s: float = sensor_setting(
        0.0015,
        title="DVL noise",
        help="Standard deviation on each axis.",
        unit="m/s",
        low=0,
        high=0.2,
        tag="S",
        source="UWSim cirs.xml, COLA2, Stonefish girona500auv_full.scn",
        advanced=True,
    )
    dvl_bias_m_s: float = sensor_setting(
        0.0,
        title="DVL bias",
        help="Constant error on each axis.",
        unit="m/s",
        low=-0.1,
        high=0.1,
        tag="E",
        source="off; 0.002 m/s is typical, no data sheet found",
        advanced=True,
    )
    dvl_scale_error: float = sensor_setting(
        0.0,
        title="DVL scale error",
        help="Relative scale error.",
        low=-0.1,
        high=0.1,
        tag="E",
        source="off; 0.003 is typical, no data sheet found",
        advanced=True,
    )
    dvl_dropout: float = sensor_setting(
        0.0,
        title="DVL drop-outs",
        help="Fraction of the measurements that are lost.",
        low=0,
        high=0.9,
        tag="E",
        source="off",
        advanced=True,
    )
    dvl_least_altitude_m: float = sensor_setting(
        0.5,
        title="DVL minimum altitude",
        help="Closer to the seabed than this the DVL has no bottom lock and keeps its last value.",
        unit="m",
        low=0,
        high=10,
        tag="S",
        source="Stonefish girona500auv_full.scn, 0.5 to 81 m",
        advanced=True,
    )
    depth_sigma_m: float = sensor_setting(
        0.01,
        title="Depth noise",
        help="Standard deviation of the depth gauge.",
        unit="m",
        low=0,
        high=0.5,
        tag="S",
        source="COLA2 sim_auv_nav_sensors.yaml",
        advanced=True,
    )
    ahrs_sigma_rad: float = sensor_setting(
        1e-4,
        title="Attitude noise",
        help="Standard deviation of roll, pitch and yaw.",
        unit="rad",
        low=0,
        high=0.1,
        tag="S",
        source="COLA2 sim_auv_nav_sensors.yaml",
        advanced=True,
    )
