"""Settings that a teacher or an organiser fixes, and what whoever submits may choose beside."""

from collections.abc import Mapping

from seamark.programs.setting_values import text_of
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.sim.benchmarks.benchmark import Benchmark


def with_fixed(
    benchmark: Benchmark, fixed: Mapping[str, object], chosen: Mapping[str, object], *, by: str
) -> dict[str, object]:
    """Return the settings of a run: what is fixed, and the others and parameters as chosen.

    Parameters
    ----------
    by
        What fixes them, such as "assignment".

    Raises
    ------
    SubmissionRejected
        A setting was chosen that is fixed to another value.
    ConfigurationInvalid
        It has an invalid value.
    """
    sent = {name: value for name, value in chosen.items() if name in fixed}
    config = benchmark.read({**fixed, **sent}).model_dump(mode="json")
    for name, value in fixed.items():
        if config.get(name) != value:
            title = benchmark.configuration.model_fields[name].title or name
            raise SubmissionRejected(
                f"This {by} fixes {title} to {text_of(value)}. Leave it as it is.", field=name
            )
    return {**chosen, **fixed}
