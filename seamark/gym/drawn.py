"""What an environment draws anew for each trial or level, and how far: domain randomisation."""

import re
from collections.abc import Mapping
from typing import Any, TypedDict

import gymnasium

from seamark.sim import registry
from seamark.sim.settings import own_files
from seamark.sim.settings.setting import group_of, limits_of, schema_extras
from seamark.sim.settings.trial_spreads import GROUP

_SAYS_SO = re.compile(r"\b(drawn|random)\b")


class Drawn(TypedDict):
    """A setting that says how far something is drawn."""

    value: Any  # of the setting
    low: float | None  # the setting may be from this
    high: float | None  # to this
    unit: str
    meaning: str


def randomisation(env_id: str, settings: Mapping[str, object] | None = None) -> dict[str, Drawn]:
    """Return the settings of an environment that say what is drawn anew, and how far, by name.

    They are its benchmark's settings of the group "Drawn per trial", and all others whose
    description tells that something is drawn or random. Each can be changed by `settings` of
    `gymnasium.make`, such as `{"drag_spread": 0.4}`.

    Parameters
    ----------
    env_id
        Such as "seamark/StationKeeping-v3".
    settings
        Those of `gymnasium.make`; the values are as with these.

    Raises
    ------
    gymnasium.error.UnregisteredEnv
        There is no such environment.
    ConfigurationInvalid, VehicleInvalid
        A setting, or the file of a vehicle, is not valid.
    """
    entry = registry.benchmark(gymnasium.spec(env_id).kwargs["benchmark"])
    config: Any = entry.read(own_files.resolved(settings or {}))
    found: dict[str, Drawn] = {}
    for name, field in type(config).model_fields.items():
        meaning = field.description or ""
        if group_of(field) == GROUP or _SAYS_SO.search(meaning):
            extras = schema_extras(field)
            limits = limits_of(field) | extras.get("x-items", {})
            found[name] = {
                "value": getattr(config, name),
                "low": limits.get("minimum", limits.get("exclusiveMinimum")),
                "high": limits.get("maximum"),
                "unit": extras.get("x-unit", ""),
                "meaning": meaning,
            }
    return found
