"""Settings of image effects other than the water's attenuation; all off by default."""

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
        help="Motion blur: how long the shutter is open, centred on the image's time; 0: none.",
        unit="s",
        low=0,
        high=0.05,
    )
    light_level: float = effect_setting(
        1.0,
        title="Daylight",
        help="Light from above, relative to the standard scene; the camera does not adapt.",
        low=0.01,
        high=2,
    )
    caustics: float = effect_setting(
        0.0,
        title="Caustics",
        help="Moving light patterns focused by surface waves: standard deviation of the daylight "
        "relative to its mean; 0: none.",
        low=0,
        high=1.5,
    )
    lamp: float = effect_setting(
        0.0,
        title="Lamp",
        help="Illuminance of a lamp ahead of the camera at 1 m distance, relative to the standard "
        "daylight; 0: off.",
        low=0,
        high=20,
    )
    lamp_cone_rad: float = effect_setting(
        0.6,
        title="Lamp cone",
        help="Angle from the axis at which the lamp's intensity is half.",
        unit="rad",
        low=0.05,
        high=1.4,
    )
    snow_per_m3: float = effect_setting(
        0.0,
        title="Marine snow",
        help="Drifting flakes of 1 to 5 mm per cubic metre of water; 0: none.",
        unit="1/m³",
        low=0,
        high=2000,
    )
    scatter_mrad: float = effect_setting(
        0.0,
        title="Forward scatter",
        help="Blur caused by the water: standard deviation per unit of optical depth; typically "
        "1.4, 0: none.",
        unit="mrad",
        low=0,
        high=10,
    )
    fish_per_min: float = effect_setting(
        0.0,
        title="Passing fish",
        help="Fish that pass between camera and target at random (seeded) times; 0: none.",
        unit="1/min",
        low=0,
        high=20,
    )
    fish_length_m: float = effect_setting(
        0.3,
        title="Fish length",
        help="Length of the passing fish.",
        unit="m",
        low=0.05,
        high=1,
    )
