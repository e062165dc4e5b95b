"""currents-v3: what currents-v2 does, in currents whose directions are spread over the trials."""

from dataclasses import replace

from seamark.sim.benchmarks.currents_v2.experiment import UnknownCurrents
from seamark.sim.benchmarks.currents_v2.settings import CurrentsConfiguration
from seamark.sim.benchmarks.currents_v3.azimuths import azimuth_share
from seamark.sim.engine.trial_conditions import TrialConditions
from seamark.sim.registry import TOOL


class SpreadCurrents(UnknownCurrents):
    """Station keeping in which the trials of a run divide the directions among themselves."""

    task = TOOL

    def drawn(self, config: CurrentsConfiguration, *, seed: int, trial: int) -> TrialConditions:
        """Return the conditions of a trial; only the direction depends on the other trials."""
        drawn = super().drawn(config, seed=seed, trial=trial)
        azimuth = config.azimuth_spread_rad * azimuth_share(seed, trial)
        return replace(drawn, current=replace(drawn.current, azimuth_rad=azimuth))


EXPERIMENT = SpreadCurrents()
