"""A number with a name, a unit and a direction."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that a run ends with; `better` is "lower" or "higher".

    `over` says how those of equally long levels become one over the run: "mean", "rms" (root of the
    mean square), "sum" or "max".
    """

    name: str
    label: str
    unit: str
    better: str
    over: str = "mean"
    meaning: str = ""  # one more sentence where the label alone does not say it
