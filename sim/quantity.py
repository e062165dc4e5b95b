"""A number with a name, a unit and a direction."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that a run ends with; `better` is "lower" or "higher"."""

    name: str
    label: str
    unit: str
    better: str
