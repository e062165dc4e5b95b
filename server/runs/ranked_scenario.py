"""What a ranked run may not change: the scenario, the seeds and the number of trials.

Settings that a ranked run would not use are refused rather than ignored, so that nobody reads a
score as the result of them.
"""

from collections.abc import Mapping

from seamark.server.runs.setting_values import label_of
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration, ConfigurationInvalid

SEED_REFUSAL = (
    "A ranked run takes its seeds from the benchmark. Leave the seed out, or start a practice run."
)


def apply(benchmark: Benchmark, sent: Mapping[str, object], config: Configuration) -> Configuration:
    """Return the configuration of a ranked run: the benchmark's scenario, the user's solution.

    Parameters
    ----------
    sent
        What the user sent. Settings of the scenario are accepted if they change nothing; entries
        that are no settings are parameters of the program.
    config
        The same, complete.

    Raises
    ------
    ConfigurationInvalid
        A setting that was sent differs from the scenario, or the solution cannot rank.
    """
    ranked = benchmark.ranked(config)
    entries = benchmark.schema()["properties"]
    errors = {
        name: _refusal(name, entries[name], getattr(ranked, name))
        for name in sent
        if name in entries and getattr(config, name) != getattr(ranked, name)
    }
    if errors:
        raise ConfigurationInvalid(errors)
    return ranked


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
