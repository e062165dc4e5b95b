"""Runs of built-in solutions in an audit file, computed again and compared with what it states."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seamark.competitions.audit_document import Audit, Entry
    from seamark.competitions.findings import Finding
    from seamark.worker.ipc.outcomes import RunOutcome

_ROUNDING = 1e-9  # of scores: another program may have added in another order


def recomputed(audit: Audit, *, quiet: bool) -> Iterator[Finding]:
    """Yield a finding for each run that needs no program but Seamark, as soon as it is computed."""
    from seamark.competitions.findings import Finding, Level
    from seamark.sim import registry
    from seamark.sim.settings import own_files

    if audit.benchmark not in registry.BENCHMARKS:
        text = f"No run was computed again: there is no benchmark {audit.benchmark} here."
        yield Finding(Level.WARNING, text)
        return
    runs = [entry for entry in audit.entries if _is_built_in(audit, entry)]
    if not runs:
        yield Finding(Level.WARNING, "No run was computed again: each needs a program.")
        return
    for setting, text in audit.files.items():
        try:
            own_files.add(setting, text.encode())
        except own_files.INVALID as reason:
            yield Finding(
                Level.PROBLEM, f"The file of the setting {setting} cannot be used: {reason}"
            )
            return
    for entry in runs:
        yield _recomputed(audit, entry, quiet=quiet)


def _is_built_in(audit: Audit, entry: Entry) -> bool:
    """Tell whether a run that succeeded is shown and is that of a built-in solution."""
    from seamark.sim import registry

    benchmark, submitted = registry.benchmark(audit.benchmark), entry.submitted
    if submitted is None or entry.scores is None or submitted.get("parts"):
        return False
    return (
        submitted.get("program") is None
        and submitted.get("benchmark") == audit.benchmark
        and submitted.get("controller") in [*benchmark.built_in, *benchmark.reference_built_in]
        and isinstance(submitted.get("configuration"), dict)
    )


def _recomputed(audit: Audit, entry: Entry, *, quiet: bool) -> Finding:
    from seamark.competitions.findings import Finding, Level
    from seamark.sim.settings.refusal import ConfigurationInvalid

    name = f"Run {entry.run} ({entry.method}, round {entry.round})"
    try:
        outcome = _outcome(audit, entry, title=name, quiet=quiet)
    except ConfigurationInvalid as reason:  # also one with a file that is not here
        return Finding(
            Level.WARNING, f"{name} cannot be computed again here: {str(reason).rstrip('.')}."
        )
    wrong = [*_differences(audit, entry, outcome)]
    if wrong:
        return Finding(Level.PROBLEM, f"{name}, computed again, {' and '.join(wrong)}.")
    return Finding(Level.GOOD, f"{name}, computed again, is the same: {outcome.digest}.")


def _outcome(audit: Audit, entry: Entry, *, title: str, quiet: bool) -> RunOutcome:
    from seamark.cli.simulator_loading import loading_shown
    from seamark.cli.solutions import sandbox_failures_explained
    from seamark.progress import Progress

    submitted: dict[str, Any] = dict(entry.submitted or {})
    with (
        sandbox_failures_explained(),
        Progress(title, quiet=quiet) as bar,
        loading_shown(bar),
    ):
        from seamark.worker.evaluation.local import Callbacks, evaluate_locally

        return evaluate_locally(
            audit.benchmark,
            submitted["configuration"],
            seed=entry.seed,
            trials=len(entry.scores or ()),
            controller=submitted["controller"],
            callbacks=Callbacks(progress=lambda at: bar.show(at.fraction)),
        )


def _differences(audit: Audit, entry: Entry, outcome: RunOutcome) -> Iterator[str]:
    from seamark.competitions.scores import trial_scores
    from seamark.sim.metrics.score_expression import ExpressionInvalid

    if outcome.failure is not None or outcome.metrics is None:
        yield f"fails: {outcome.sentence.rstrip('.')}"
        return
    if entry.digest is not None and outcome.digest != entry.digest:
        yield f"has the digest {outcome.digest} instead of {entry.digest}"
    config = dict(entry.submitted or {})["configuration"]
    try:
        scores = trial_scores(audit.benchmark, config, outcome.metrics["trials"])
    except ExpressionInvalid as reason:
        yield f"has no score: {str(reason).rstrip('.')}"
        return
    stated = entry.scores or ()
    wrong = [
        at
        for at, (one, other) in enumerate(zip(scores, stated, strict=True), 1)
        if not abs(one - other) <= _ROUNDING
    ]
    if wrong:
        yield f"has other scores in {len(wrong)} of {len(scores)} trials"
