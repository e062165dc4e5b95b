"""The current of one level, by its settings."""

from seamark.sim.camera.target import Target, start_pose
from seamark.sim.engine.world import target_and_optics
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.physics.current import Current, Pattern, Shear
from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.tabulation import (
    Motion,
    Site,
    Stretch,
    current_of,
    stretch_of,
)
from seamark.sim.physics.water_motion.waves import Waves
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.water_motion import NONE, WaterMotionSettings


def level_current(
    config: WaterMotionSettings,
    site: Site,
    speed: float,
    random: Streams,
    *,
    pattern: Pattern,
    exponent: float = 0.0,
) -> Current:
    """Return the current of a level.

    Parameters
    ----------
    speed : float [m/s]
        The level's.
    pattern
        Of the sinusoids and gusts that a place or a record replaces.
    exponent
        Of the profile that a place or a record replaces; 0: the same speed at all depths.
    """
    shear = Shear(exponent=exponent, bottom_m=site.bottom_m, height_m=site.height_m)
    base = Current(
        speed,
        pattern=pattern,
        shear=shear if exponent else None,
        rng=random.gust,
        duration_s=site.duration_s,
    )
    if not config.is_tabulated():
        return base
    waves = Waves(config.wave_height_m, config.wave_period_s) if config.wave_height_m else None
    motion = Motion(
        place=PLACES.get(config.current_place),
        record=None if config.current_record == NONE else records.load(config.current_record),
        waves=waves,
        base=None if config.has_own_profile() else base,
    )
    return current_of(speed, motion, site, random)


def level_stretch(
    config: WaterMotionSettings, site: Site, speed: float, random: Streams
) -> Stretch | None:
    """Return the stretch of its record that a level gets; None without one, or in still water."""
    if config.current_record == NONE or speed == 0.0:
        return None
    record = records.load(config.current_record)
    return stretch_of(speed, record, site, random.record)


def site_of(
    config: ExperimentSettings, azimuth_rad: float, *, target: Target | None = None
) -> Site:
    """Return where the vehicle of a level starts, and where the current comes from.

    `target` is used instead of that of the settings.
    """
    configured, optics = target_and_optics(config)
    target = target or configured
    return Site(
        bottom_m=target.seabed_m,
        start_m=float(start_pose(optics, target, config.altitude_m)[2]),
        azimuth_rad=azimuth_rad,
        duration_s=config.level_duration_s,
    )
