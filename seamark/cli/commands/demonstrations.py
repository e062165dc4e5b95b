"""`seamark demonstrations`: episodes of a built-in expert, to train a policy by imitation."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from seamark.cli.configuration import benchmark_of, configuration_of
from seamark.cli.console import INTERRUPTED, exit_with, print_json
from seamark.cli.options import benchmark_argument, configuration_options, json_option
from seamark.demonstrations.layouts import LAYOUTS
from seamark.failures import UsageRefused
from seamark.progress import Progress

if TYPE_CHECKING:
    from seamark.demonstrations.description import Description
    from seamark.demonstrations.episodes import Outcome
    from seamark.demonstrations.layouts import Layout
    from seamark.demonstrations.recording import Plan
    from seamark.demonstrations.spool import Spool
    from seamark.sim.settings.configuration import Configuration

FIRST_SEED = 1_000_000


@click.command()
@benchmark_argument
@click.option(
    "--episodes",
    type=click.IntRange(1, 1_000_000),
    default=200,
    show_default=True,
    help="How many to write.",
)
@click.option(
    "--format",
    "name",
    type=click.Choice(list(LAYOUTS)),
    default=next(iter(LAYOUTS)),
    show_default=True,
    help="; ".join(f"{name}: {layout.label}" for name, layout in LAYOUTS.items()) + ".",
)
@click.option(
    "--out",
    "--output",
    "out",
    type=click.Path(path_type=Path),
    metavar="FOLDER",
    help="A new folder.  [default: named after benchmark and format]",
)
@click.option(
    "--expert",
    metavar="NAME",
    default="scripted",
    show_default=True,
    help="The built-in solution that acts.",
)
@click.option("--successes", is_flag=True, help="Write only episodes that get the whole credit.")
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=FIRST_SEED,
    show_default=True,
    help="Seed of the first episode; each has the next one.",
)
@click.option(
    "--reward",
    type=click.Choice(["dense", "sparse"]),
    default="dense",
    show_default=True,
    help="As of the environment.",
)
@click.option(
    "--dtype",
    type=click.Choice(["float32", "float64"]),
    help="Of observations and actions.  [default: float32 for lerobot, else float64]",
)
@configuration_options
@click.option(
    "--jobs",
    "--workers",
    "jobs",
    type=click.IntRange(1, 256),
    help="Episodes at a time; the result does not depend on it.  [default: one per core]",
)
@json_option
def demonstrations(  # noqa: PLR0913 (one argument per option is click's way)
    *,
    benchmark: str,
    episodes: int,
    name: str,
    out: Path | None,
    expert: str,
    successes: bool,
    seed: int,
    reward: str,
    dtype: str | None,
    pairs: tuple[str, ...],
    config: Path | None,
    jobs: int | None,
    as_json: bool,
) -> None:
    """Write episodes of a built-in expert, to train a policy by imitation.

    Observations and actions are those of the Gymnasium environment, so that an episode can be
    replayed there. Levels take turns. Images are in it with --set images=both. The same options
    give the same files; after Ctrl-C the same command goes on.

    \b
    Examples:
      seamark demonstrations recover-v1 --episodes 200
      seamark demonstrations valve-v1 --format minari --successes --set levels=0,0.1,0.2
      seamark demonstrations recover-v1 --set images=both --expert resolved-rate --out seen
    """
    from seamark.demonstrations.description import describe
    from seamark.demonstrations.episodes import Task
    from seamark.demonstrations.recording import Plan

    layout = LAYOUTS[name]
    _refuse_without_packages(layout)
    _refuse_expert(benchmark, expert)
    checked: Any = configuration_of(benchmark, config, pairs)
    task = Task(
        benchmark=benchmark,
        settings=_changed(checked),
        expert=expert,
        reward=reward,
        dtype=dtype or layout.dtype,
    )
    plan = Plan(
        task=task,
        first_seed=seed,
        levels=len(checked.level_values()),
        episodes=episodes,
        only_successes=successes,
    )
    _refuse_seeds(plan)
    description = describe(task)
    if why := layout.refusal(description):
        raise UsageRefused(why)
    target = out or Path(f"{benchmark}-{name}")
    cores = jobs or len(os.sched_getaffinity(0))
    kept, made = _record(Order(plan, layout), description, target, jobs=cores, quiet=as_json)
    _report(target, kept, made, as_json=as_json)


class Order(NamedTuple):
    """What is recorded and how it is written."""

    plan: Plan
    layout: Layout

    def document(self, description: Description) -> dict[str, Any]:
        """Return all that decides what an attempt gives, as plain JSON values."""
        chosen = {"seed": self.plan.first_seed, "successes": self.plan.only_successes}
        return description.document() | {"format": self.layout.name, **chosen}


def _refuse_without_packages(layout: Layout) -> None:
    from seamark.cli.extras import install_line, missing

    if missing(layout.packages):
        raise UsageRefused(
            f"The format {layout.name} needs further packages: {install_line('demonstrations')}."
        )


def _refuse_expert(name: str, expert: str) -> None:
    """Refuse a benchmark or an expert that does not fit."""
    from seamark.sim import registry

    benchmark = benchmark_of(name)
    if not benchmark.moves_arm:
        fitting = ", ".join(each for each in registry.BENCHMARKS if _moves_arm(each))
        raise UsageRefused(f"{name} has no demonstrations. Benchmarks that have some: {fitting}.")
    if expert not in benchmark.built_in:
        known = ", ".join(benchmark.built_in)
        raise UsageRefused(f"There is no built-in solution {expert}. Available: {known}.")


def _moves_arm(name: str) -> bool:
    return benchmark_of(name).moves_arm


def _refuse_seeds(plan: Plan) -> None:
    from seamark.sim.engine.seeds import SEED_MAX

    *_, last = plan.attempts()
    if last.seed > SEED_MAX:
        raise UsageRefused(f"--seed: the seed of the last episode would be beyond {SEED_MAX}.")


def _changed(config: Configuration) -> dict[str, Any]:
    """Return the settings that are not the benchmark's own, as plain JSON values."""
    values: Mapping[str, Any] = config.model_dump(mode="json")
    usual = type(config)().model_dump(mode="json")
    return {name: value for name, value in values.items() if value != usual.get(name)}


def _record(
    order: Order, description: Description, out: Path, *, jobs: int, quiet: bool
) -> tuple[list[Outcome], int]:
    """Record and write, and return what is kept and how many attempts were made."""
    from seamark.demonstrations.recording import TooFewSuccesses
    from seamark.demonstrations.spool import OutputRefused, Spool

    spool = Spool(out)
    try:
        with spool.opened(order.document(description)):
            return _recorded(order, description, spool, jobs=jobs, quiet=quiet)
    except (OutputRefused, TooFewSuccesses) as reason:
        raise UsageRefused(str(reason)) from None
    except OSError as error:
        raise UsageRefused(f"{out} cannot be written: {error.strerror or error}.") from None
    except KeyboardInterrupt:
        left = f"{spool.folder} has the episodes so far, and the same command goes on with them."
        click.echo(f"Interrupted. {left}", err=True)
        exit_with(INTERRUPTED)


def _recorded(
    order: Order, description: Description, spool: Spool, *, jobs: int, quiet: bool
) -> tuple[list[Outcome], int]:
    from seamark.cli.simulator_loading import loading_shown
    from seamark.demonstrations.layouts import Episode
    from seamark.demonstrations.recording import Recording

    plan, made = order.plan, 0
    title = f"{plan.task.benchmark}, {plan.task.expert}"
    with Recording(plan, spool, order.layout, workers=jobs) as recording:
        with Progress(title, quiet=quiet) as bar, loading_shown(bar):

            def show(outcome: Outcome, kept: int) -> None:
                nonlocal made
                made = outcome.number + 1
                bar.show(kept / plan.episodes, f"{kept} of {plan.episodes} episodes")

            kept = recording.run(show)
    with Progress(f"{len(kept)} episodes as {order.layout.name}", quiet=quiet) as bar:

        def episodes() -> Iterator[Episode]:
            for done, outcome in enumerate(kept, start=1):
                yield Episode(outcome, spool.arrays(outcome.number))
                bar.show(done / len(kept))

        spool.finish(lambda folder: order.layout.write(description, episodes(), folder))
    return kept, made


def _report(out: Path, kept: list[Outcome], attempts: int, *, as_json: bool) -> None:
    good = sum(outcome.success for outcome in kept)
    size = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    steps = sum(outcome.steps for outcome in kept)
    if as_json:
        told = {"out": str(out), "episodes": len(kept), "successes": good, "attempts": attempts}
        print_json(told | {"steps": steps, "bytes": size})
        return
    tried = f", of {attempts} attempts" if attempts > len(kept) else ""
    click.echo(f"{len(kept)} episodes{tried}, {good} successful, {steps} steps: {out}")
    click.echo(f"{size / 2**20:.1f} MiB")
