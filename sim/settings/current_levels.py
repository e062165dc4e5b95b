"""A vehicle in closed loop, in levels of increasing mean current."""

from itertools import pairwise

from seamark.sim.metrics.metric import Metric
from seamark.sim.settings.current import CurrentSettings
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.grid import SPEED, GridSettings


class CurrentLevels(ExperimentSettings, GridSettings, CurrentSettings):
    """What levels of increasing mean current have in common; a subclass has them as `levels`."""

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        levels = self.base_levels()
        errors = self.current_errors() | self.water_motion_errors(level_s=self.level_duration_s)
        if any(b <= a for a, b in pairwise(levels)):
            errors["levels"] = "levels (Current levels) must increase from one to the next."
        return errors | super().cross_field_errors()

    def level_metric(self) -> Metric:
        """Return the current's speed."""
        return Metric("speed", "Current", "m/s", "higher")

    def level_values(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s]; in a grid, of each of its points."""
        return tuple(point[SPEED] for point in self.points())
