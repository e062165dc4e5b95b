"""Two vehicles that take turns from trial to trial, so that a score is not that of one hull."""

from typing import Any, ClassVar, Self

from seamark.sim.settings.experiment import ExperimentSettings, experiment_setting
from seamark.sim.vehicles import load

BOTH = "both"
MEASURED = ("girona500", "bluerov2-heavy-v2")  # in even, in odd trials


def two_vehicles_setting(
    single: tuple[str, ...] = MEASURED, *, own: str = "its own defaults"
) -> Any:
    """Return the field `vehicle` of a class of settings with `TwoVehicles`.

    Parameters
    ----------
    single
        Names of those that a practice run may choose for all trials.
    own
        What each vehicle has of its own, in words.
    """
    return experiment_setting(
        BOTH,
        title="Vehicle",
        help=f"Both: Girona 500 in even trials, BlueROV2 Heavy in odd ones, each with {own}.",
        choices={BOTH: "Girona 500 and BlueROV2 Heavy in turn"}
        | {name: load(name).title for name in single},
    )


class TwoVehicles(ExperimentSettings):
    """What two vehicles that take turns mean; the field is `two_vehicles_setting`.

    Last of the bases of a class, since the first one's fields win.
    """

    alternating: ClassVar[tuple[str, ...]] = MEASURED

    def vehicles(self) -> tuple[str, ...]:
        """Return the vehicles that take turns from trial to trial."""
        return self.alternating if self.vehicle == BOTH else (self.vehicle,)

    def for_trial(self, trial: int) -> Self:
        """Return the configuration of one trial, with its vehicle and that vehicle's defaults."""
        if self.vehicle != BOTH:
            return self
        name = self.alternating[trial % len(self.alternating)]
        return self.model_copy(update={"vehicle": name, **load(name).defaults})
