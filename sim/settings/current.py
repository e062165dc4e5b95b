"""Settings of the water current.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math

from seamark.sim.settings.water_motion import NONE, WaterMotionSettings, current_setting

# Of the settings that a place or a record replaces.
_SINUSOIDS = {"current_place": [NONE], "current_record": [NONE]}
# Of the settings of water that moves: the value without an effect.
_STILL = {
    "current_shear": "0.0",
    "current_place": NONE,
    "current_record": NONE,
    "wave_height_m": "0.0",
}


class CurrentSettings(WaterMotionSettings):
    """A current whose mean speed is set elsewhere, such as by the level."""

    current_law: str = current_setting(
        "relative",
        title="Current model",
        help="Relative velocity is physical; the body force is how the paper's simulator did it.",
        choices={
            "relative": "Relative velocity of the water",
            "force": "Force on the body (the paper's simulator)",
        },
    )
    current_azimuth_rad: float = current_setting(
        0.0,
        title="Direction of the current",
        help="Where the current comes from, relative to the bow: 0 ahead, 1.57 starboard (beam).",
        unit="rad",
        low=-math.pi,
        high=math.pi,
        tag="E",
        source="the published direction overpowers the real vehicle's one sway thruster",
    )
    current_swing_rad: float = current_setting(
        0.7,
        title="Direction amplitude",
        help="Amplitude of the sinusoidal direction change.",
        unit="rad",
        low=0,
        high=1.57,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
        applies=_SINUSOIDS,
    )
    current_swing_period_s: float = current_setting(
        30.0,
        title="Direction period",
        help="Period of the sinusoidal direction change.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
        applies=_SINUSOIDS,
    )
    current_wave_m_s: float = current_setting(
        0.005,
        title="Speed amplitude",
        help="Amplitude of the sinusoidal speed change; none at 0 m/s.",
        unit="m/s",
        low=0,
        high=0.5,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
        applies=_SINUSOIDS,
    )
    current_wave_period_s: float = current_setting(
        4.0,
        title="Speed period",
        help="Period of the sinusoidal speed change.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
        applies=_SINUSOIDS,
    )
    current_gust: float = current_setting(
        0.05,
        title="Gusts",
        help="Standard deviation of the random part, relative to the mean speed.",
        low=0,
        high=0.5,
        tag="E",
        source="the original draws 1 % white noise at every call, which depends on the call rate",
        applies=_SINUSOIDS,
    )
    current_gust_time_s: float = current_setting(
        10.0,
        title="Gust time constant",
        help="Correlation time of the gusts (Ornstein-Uhlenbeck process).",
        unit="s",
        low=0.1,
        high=120,
        tag="E",
        source="several gusts per level",
        applies=_SINUSOIDS,
    )
    current_shear: float = current_setting(
        0.0,
        title="Current shear",
        help="Exponent n: at height h above the seabed the speed is (h/h0)^n of that at the "
        "initial height h0. Typically 1/7; 0: uniform.",
        low=0,
        high=1,
        tag="S",
        source="law and 1/7: DNV-RP-C205 (2010) 4.1.4; off in the published experiment",
        advanced=True,
        applies=_SINUSOIDS,
    )
    current_force_share: float = current_setting(
        0.134,
        title="Body force factor",
        help="The factor k of the body force 410 k v² N; 0.134 reproduces the paper's 18 px.",
        low=0,
        high=1,
        tag="D",
        source="fitted to one published number, 18 px at 0.4 m/s",
        advanced=True,
    )

    def current_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings of the current."""
        errors: dict[str, str] = {}
        if self.current_law == "force":
            errors |= {
                name: f"{name} ({type(self).model_fields[name].title}) must be {none} when the "
                "current acts as a body force: the water itself is at rest."
                for name, none in _STILL.items()
                if str(getattr(self, name)) != none
            }
        if self.current_shear and self.has_own_profile():
            errors["current_shear"] = (
                "current_shear (Current shear) must be 0 with a place or a record: they have a "
                "profile of their own."
            )
        return errors
