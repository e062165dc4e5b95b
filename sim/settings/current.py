"""Settings of the water current.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math
from functools import partial

from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting

current_setting = partial(setting, group="Current", role="scenario")


class CurrentSettings(Configuration):
    """A current whose mean speed is set elsewhere, such as by the level."""

    current_law: str = current_setting(
        "relative",
        title="The current acts as",
        help="Relative velocity is physics; the body force is what the paper's simulator did.",
        choices={
            "relative": "Relative velocity of the water",
            "force": "Force on the body (the paper's simulator)",
        },
    )
    current_azimuth_rad: float = current_setting(
        0.0,
        title="Direction of the current",
        help="Where the water comes from, from the bow: 0 bow-on, 1.57 starboard (beam).",
        unit="rad",
        low=-math.pi,
        high=math.pi,
        tag="E",
        source="the published direction overpowers the real vehicle's one sway thruster",
    )
    current_swing_rad: float = current_setting(
        0.7,
        title="Swing of the direction",
        help="Amplitude of the sinusoid in the direction.",
        unit="rad",
        low=0,
        high=1.57,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_swing_period_s: float = current_setting(
        30.0,
        title="Period of the swing",
        help="Period of the sinusoid in the direction.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_wave_m_s: float = current_setting(
        0.005,
        title="Wave of the speed",
        help="Amplitude of the sinusoid in the speed; level 0 has none.",
        unit="m/s",
        low=0,
        high=0.5,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_wave_period_s: float = current_setting(
        4.0,
        title="Period of the wave",
        help="Period of the sinusoid in the speed.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_gust: float = current_setting(
        0.05,
        title="Gusts",
        help="Standard deviation of the random part, as a share of the level.",
        low=0,
        high=0.5,
        tag="E",
        source="the original draws 1 % white noise at every call, which depends on the call rate",
    )
    current_gust_time_s: float = current_setting(
        10.0,
        title="Gust time constant",
        help="How long a gust lasts (Ornstein-Uhlenbeck process).",
        unit="s",
        low=0.1,
        high=120,
        tag="E",
        source="some of them within a level",
    )
    current_shear: float = current_setting(
        0.0,
        title="Shear over the bottom",
        help="Exponent n: at height h the water has (h/h0)^n of its speed at the start's height "
        "h0. 1/7 is usual, 0 is the same at every depth.",
        low=0,
        high=1,
        tag="S",
        source="law and 1/7: DNV-RP-C205 (2010) 4.1.4; off in the published experiment",
        advanced=True,
    )
    current_force_share: float = current_setting(
        0.134,
        title="Share of the body force",
        help="Only as body force, 410 k v² N: the share k; 0.134 gives the paper's 18 px.",
        low=0,
        high=1,
        tag="D",
        source="fitted to one published number, 18 px at 0.4 m/s",
        advanced=True,
    )

    def current_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings of the current."""
        if not self.current_shear or self.current_law != "force":
            return {}
        return {
            "current_shear": "current_shear (Shear over the bottom) must be 0 when the current "
            "acts as a body force: the water itself is at rest."
        }
