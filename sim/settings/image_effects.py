"""Settings of what disturbs the pictures beside the water; all off by default."""

from functools import partial

from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting

effect_setting = partial(
    setting, group="Water and camera", role="scenario", tag="E", advanced=True, source="an option"
)


class EffectSettings(Configuration):
    """Motion blur, light, marine snow, forward scatter and fish."""

    camera_exposure_s: float = effect_setting(
        0.0,
        title="Exposure time",
        help="Motion blur: how long the shutter is open, half before and half after a picture's "
        "instant; 0 is none.",
        unit="s",
        low=0,
        high=0.05,
    )
    light_level: float = effect_setting(
        1.0,
        title="Daylight",
        help="Light from above as a share of the usual; the camera does not adapt.",
        low=0.01,
        high=2,
    )
    caustics: float = effect_setting(
        0.0,
        title="Caustics",
        help="Daylight that the waves above focus into a running net: its standard deviation as a "
        "share of its mean; 0 is none.",
        low=0,
        high=1.5,
    )
    lamp: float = effect_setting(
        0.0,
        title="Lamp",
        help="Light of a lamp ahead of the camera on a surface 1 m below it, in units of the usual "
        "daylight; 0 is off.",
        low=0,
        high=20,
    )
    lamp_cone_rad: float = effect_setting(
        0.6,
        title="Cone of the lamp",
        help="Angle from its axis at which the lamp's intensity is half.",
        unit="rad",
        low=0.05,
        high=1.4,
    )
    snow_per_m3: float = effect_setting(
        0.0,
        title="Marine snow",
        help="Flakes of 1 to 5 mm that drift in a cubic metre of water; 0 is none.",
        unit="1/m³",
        low=0,
        high=2000,
    )
    scatter_mrad: float = effect_setting(
        0.0,
        title="Forward scatter",
        help="Blur by the water: its standard deviation per unit of optical depth; 1.4 is usual, "
        "0 is none.",
        unit="mrad",
        low=0,
        high=10,
    )
    fish_per_min: float = effect_setting(
        0.0,
        title="Passing fish",
        help="Fish that cross between camera and target at seeded moments; 0 is none.",
        unit="1/min",
        low=0,
        high=20,
    )
    fish_length_m: float = effect_setting(
        0.3,
        title="Length of a fish",
        help="How long the passing fish are.",
        unit="m",
        low=0.05,
        high=1,
    )
