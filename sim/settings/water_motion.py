"""Settings of how the water moves beside its mean speed: place, record and waves.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.record import STILL_M_S
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting

current_setting = partial(setting, group="Current", role="scenario")
NONE = "none"


class WaterMotionSettings(Configuration):
    """A current as at a place or as it was recorded, and the waves above it."""

    current_place: str = current_setting(
        NONE,
        title="Place",
        help="Turbulence and profile as at such a place, instead of sinusoids and gusts. The level "
        "remains the mean speed at the start.",
        choices={NONE: "None: sinusoids and gusts"}
        | {name: place.title for name, place in PLACES.items()},
        advanced=True,
    )
    current_record: str = current_setting(
        NONE,
        title="Recorded current",
        help="The stretch of a record whose mean lies nearest to the level, turned and scaled to "
        "it, instead of a steady current. With a place, its turbulence is added.",
        choices={NONE: "None"} | {name: records.load(name).title for name in records.SHIPPED},
        advanced=True,
    )
    wave_height_m: float = current_setting(
        0.0,
        title="Significant wave height",
        help="Of surface waves (JONSWAP) that move the water below them and come from where the "
        "current comes from; 0: none.",
        unit="m",
        low=0,
        high=2,
        advanced=True,
    )
    wave_period_s: float = current_setting(
        5.0,
        title="Peak wave period",
        help="Period of the waves' spectral peak.",
        unit="s",
        low=2,
        high=20,
        tag="E",
        source="a fresh breeze over a bay",
        advanced=True,
    )

    def is_tabulated(self) -> bool:
        """Return whether the water moves as a table has it."""
        return self.has_own_profile() or self.wave_height_m > 0.0

    def has_own_profile(self) -> bool:
        """Return whether a place or a record says how the current changes with depth."""
        return self.current_place != NONE or self.current_record != NONE

    def water_motion_errors(self, *, level_s: float) -> dict[str, str]:
        """Return setting -> message for a record that levels [s] cannot use."""
        if self.current_record == NONE:
            return {}
        record = records.load(self.current_record)
        if record.duration_s < level_s:
            return {
                "current_record": f"current_record (Recorded current) must be at least as long as "
                f"a level of {level_s:g} s, not {record.duration_s:g} s."
            }
        if record.strongest_mean(level_s) < STILL_M_S:
            return {
                "current_record": "current_record (Recorded current) must have a stretch as long "
                f"as a level with a mean of at least {STILL_M_S:g} m/s."
            }
        return {}
