"""Settings of currents-v3: those of currents-v2, with vehicles whose forces were measured."""

from typing import Self

from seamark.sim.benchmarks.currents_v2.settings import BOTH
from seamark.sim.benchmarks.currents_v2.settings import CurrentsConfiguration as Before
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.vehicles import load

ALTERNATING = ("girona500", "bluerov2-heavy-v2")  # in even, in odd trials


class CurrentsConfiguration(Before):
    """Settings of currents-v3. Seed, trials and controller are not part of it."""

    vehicle: str = experiment_setting(
        BOTH,
        title="Vehicle",
        help="Both: Girona 500 in even trials, BlueROV2 Heavy in odd ones, each with its own "
        "defaults.",
        choices={BOTH: "Girona 500 and BlueROV2 Heavy in turn"}
        | {name: load(name).title for name in ALTERNATING},
    )

    def vehicles(self) -> tuple[str, ...]:
        """Return the vehicles that take turns from trial to trial."""
        return ALTERNATING if self.vehicle == BOTH else (self.vehicle,)

    def for_trial(self, trial: int) -> Self:
        """Return the configuration of one trial, with its vehicle and that vehicle's defaults."""
        if self.vehicle != BOTH:
            return self
        name = ALTERNATING[trial % len(ALTERNATING)]
        return self.model_copy(update={"vehicle": name, **load(name).defaults})
