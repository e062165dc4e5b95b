"""Settings of what can break."""

from functools import partial

from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting
from seamark.sim.vehicles import most_thrusters

fault_setting = partial(setting, group="Faults", role="scenario", advanced=True)


class FaultSettings(Configuration):
    """One thruster that fails in every level."""

    fault_thruster: int = fault_setting(
        -1,
        title="Broken thruster",
        help="Index as in the column thrust_0; -1 for none.",
        low=-1,
        high=most_thrusters() - 1,
    )
    fault_efficiency: float = fault_setting(
        0.0,
        title="What is left of its thrust",
        help="Share of the thrust that the broken thruster still gives; 0 is dead.",
        low=0,
        high=1,
    )
    fault_delay_s: float = fault_setting(
        0.0,
        title="Its delay",
        help="How much later than commanded the broken thruster acts.",
        unit="s",
        low=0,
        high=5,
    )
    fault_from_s: float = fault_setting(
        0.0,
        title="Broken from",
        help="Time into each level at which the thruster breaks.",
        unit="s",
        low=0,
        high=600,
    )
