"""What a ranked run may not change: the scenario, the seeds and the number of trials.

Settings that a ranked run would not use are refused rather than ignored, so that nobody reads a
score as the result of them.
"""

from collections.abc import Collection, Mapping

from seamark.programs.setting_values import in_effect, label_of
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid

SEED_REFUSAL = (
    "A ranked run takes its seeds from the benchmark. Leave the seed out, or start a practice run."
)


def apply(
    benchmark: Benchmark,
    sent: Mapping[str, object],
    config: Configuration,
    *,
    controller: str,
    parts: Collection[str] = (),
) -> Configuration:
    """Return the configuration of a ranked run: the benchmark's scenario, the user's solution.

    Settings without an effect have their defaults: what is in effect alone decides the seeds.

    Parameters
    ----------
    sent
        What the user sent. Settings of the scenario, and those without an effect, are accepted if
        they change nothing; entries that are no settings are parameters of the program.
    config
        The same, complete.
    parts
        Roles of further programs, which take the place of built-in solutions.

    Raises
    ------
    ConfigurationInvalid
        A setting that was sent differs from the scenario or has no effect, or the solution cannot
        rank.
    """
    ranked = benchmark.ranked(config)
    effective = in_effect(benchmark, ranked.model_dump(), controller, parts=parts)
    ranked = benchmark.ranked(benchmark.configuration.read(_chosen(ranked, effective)))
    entries = benchmark.schema()["properties"]
    errors = {
        name: _refusal(name, entries[name], getattr(ranked, name))
        if name in effective or entries[name]["x-role"] == "scenario"
        else _without_effect(name, entries[name])
        for name in sent
        if name in entries and getattr(config, name) != getattr(ranked, name)
    }
    if errors:
        raise ConfigurationInvalid(errors)
    return ranked


def _chosen(config: Configuration, names: Collection[str]) -> dict[str, object]:
    return {name: value for name, value in config.model_dump().items() if name in names}


def with_effect(
    benchmark: Benchmark,
    config: Mapping[str, object],
    *,
    controller: str,
    parts: Collection[str] = (),
) -> dict[str, object]:
    """Return a stored configuration as `apply` accepts it: without settings that have no effect.

    Earlier versions stored those as they were sent, such as the options of another tracker.
    """
    settings = benchmark.schema()["properties"]
    restored = benchmark.restore(config).model_dump()
    effective = in_effect(benchmark, restored, controller, parts=parts)
    return {
        name: value for name, value in config.items() if name in effective or name not in settings
    }


def trials_refusal(trials: int) -> str:
    """Return why a ranked run cannot have another number of trials."""
    return f"A ranked run has {trials} trials. Leave the number out, or start a practice run."


def _refusal(name: str, entry: Mapping[str, object], fixed: object) -> str:
    unit = f" {entry['x-unit']}" if entry.get("x-unit") else ""
    value = label_of(entry, fixed)
    at = f"at {value}{unit}" if value else "as empty"
    return (
        f"{name} ({entry['title']}) is fixed {at} in ranked runs. "
        "Leave it out, or start a practice run."
    )


def _without_effect(name: str, entry: Mapping[str, object]) -> str:
    return (
        f"{name} ({entry['title']}) has no effect with the other choices, so a ranked run does "
        "not have it. Leave it out."
    )
