"""Settings of thruster faults."""

from functools import partial

from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting
from seamark.sim.vehicles import most_thrusters

fault_setting = partial(setting, group="Faults", role="scenario", advanced=True)


class FaultSettings(Configuration):
    """One thruster that is faulty in every level."""

    fault_thruster: int = fault_setting(
        -1,
        title="Faulty thruster",
        help="Index as in the column thrust_0; -1 for none.",
        low=-1,
        high=most_thrusters() - 1,
    )
    fault_efficiency: float = fault_setting(
        0.0,
        title="Remaining thrust",
        help="Fraction of its thrust that the faulty thruster still produces; 0: none.",
        low=0,
        high=1,
    )
    fault_delay_s: float = fault_setting(
        0.0,
        title="Thruster delay",
        help="Additional delay of the faulty thruster.",
        unit="s",
        low=0,
        high=5,
    )
    fault_from_s: float = fault_setting(
        0.0,
        title="Fault starts at",
        help="Time into each level at which the fault begins.",
        unit="s",
        low=0,
        high=600,
    )
