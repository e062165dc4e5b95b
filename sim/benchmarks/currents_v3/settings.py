"""Settings of currents-v3: those of currents-v2, with vehicles whose forces were measured."""

from seamark.sim.benchmarks.currents_v2.settings import CurrentsConfiguration as Before
from seamark.sim.settings.two_vehicles import MEASURED, two_vehicles_setting


class CurrentsConfiguration(Before):
    """Settings of currents-v3. Seed, trials and controller are not part of it."""

    alternating = MEASURED

    vehicle: str = two_vehicles_setting()
