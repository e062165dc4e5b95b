"""`seamark bridge`: programs that exist already take part in a run on this machine."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from seamark.cli.commands.run import LocalRun, report
from seamark.cli.console import INTERRUPTED, exit_with
from seamark.cli.options import benchmark_argument, bridged_run_options, json_option, token_option
from seamark.failures import PlatformFailed, UsageRefused

if TYPE_CHECKING:
    from seamark.sim.engine.program import Program
    from seamark.sim.settings.experiment import ExperimentSettings
    from seamark.worker.ipc.outcomes import RunOutcome

LOCAL = "127.0.0.1"
ROSBRIDGE_PORT = 9090  # as rosbridge_server's
ARDUPILOT_PORT = 9002  # where SITL looks for physics
# What an autopilot needs unless it is set: its loop of 400 Hz must get a state each time.
ARDUSUB_SETTINGS = {"vehicle": "bluerov2-heavy", "physics_step_s": 0.0025}
Say = Callable[[str], None]
Command = Callable[..., Any]
Decorator = Callable[[Command], Command]


@click.group()
def bridge() -> None:
    """Connect programs that exist already: ROS programs and autopilots."""


def _listening_options(port: int, *, word: str, within_s: float, what: str) -> Decorator:
    """Add --host, --port and --answer-within."""
    options = (
        click.option("--host", default=LOCAL, show_default=True, help="Address to listen on."),
        click.option(
            "--port",
            type=click.IntRange(0, 65535),
            default=port,
            show_default=True,
            help=f"{word} to listen on; 0: one that is free.",
        ),
        click.option(
            "--answer-within",
            type=click.FloatRange(0.1, 3600.0),
            default=within_s,
            show_default=True,
            metavar="SECONDS",
            help=f"How long the simulation waits for each {what}.",
        ),
    )

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


@bridge.command()
@benchmark_argument
@bridged_run_options
@_listening_options(ROSBRIDGE_PORT, word="Port", within_s=10.0, what="velocity reference")
@click.option(
    "--real-time",
    is_flag=True,
    help="Follow the wall clock instead of waiting for the program; not reproducible.",
)
@click.option(
    "--axes",
    type=click.Choice(["ned", "enu"]),
    default="ned",
    show_default=True,
    help="Axes of topics and references: north, east, down and forward, starboard, down; or those "
    "of ROS (REP 103): east, north, up and forward, port, up.",
)
@click.option(
    "--origin",
    "origins",
    multiple=True,
    metavar="URL",
    help="Let pages of this origin connect, such as https://example.org; repeatable.  "
    "[default: pages of this machine]",
)
@click.option(
    "--server",
    metavar="URL",
    help="Run on this server, which needs --token; the program connects to this machine all the "
    "same.  [default: run here]",
)
@token_option
@json_option
def rosbridge(  # noqa: PLR0913  # one argument per option
    *,
    benchmark: str,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int | None,
    trials: int | None,
    out: Path | None,
    host: str,
    port: int,
    answer_within: float,
    real_time: bool,
    axes: str,
    origins: tuple[str, ...],
    server: str | None,
    token: str | None,
    as_json: bool,
) -> None:
    """Evaluate a program that speaks rosbridge v2, such as one with roslibpy or roslibjs.

    The bridge publishes each observation and waits for the velocity reference that answers it, so
    a program that publishes exactly one per observation gives the same digest every time. The run
    begins with the first reference. docs/bridges.md has the topics.

    \b
    Examples:
      seamark bridge rosbridge currents-v1 --seed 7 --out result
      seamark bridge rosbridge currents-v3 --set levels=0.2 --axes enu
      seamark bridge rosbridge currents-v1 --server https://seamark.example --token $TOKEN
    """
    _refuse_without_websockets()
    if server is not None:
        _refuse_what_a_server_decides()
    from seamark.bridge.rosbridge.axes import Axes
    from seamark.bridge.rosbridge.lock_step import LockStep, Rules
    from seamark.bridge.rosbridge.program import RosProgram, opened
    from seamark.bridge.rosbridge.server import TcpAddress
    from seamark.cli.configuration import read_settings, typed_if_known
    from seamark.cli.server_bridge import finish, run_on_server
    from seamark.sim.engine.world import target_and_optics
    from seamark.worker.evaluation.bridged import result_message

    address, say, spoken = TcpAddress(host, port, origins), _say(quiet=as_json), Axes(axes)
    if server is not None:
        given = typed_if_known(benchmark, read_settings(config, pairs))
        wanted = {"benchmark": benchmark, "config": given, "seed": seed, "trials": trials}
        wanted |= {"axes": axes}
        finish(run_on_server(server, token, wanted, address, say), as_json=as_json)
    run = _local_run(benchmark, "rosbridge", pairs, config, trials=trials, seed=seed)
    restored = _restored(run)
    (_target, optics), arm = target_and_optics(restored), restored.chosen_arm()
    with ExitStack() as stack:
        rules = Rules(answer_s=answer_within, real_time=real_time)
        lock_step = LockStep(rules, joints=len(arm.motors()) if arm else 0)
        try:
            behind = stack.enter_context(opened(lock_step, address, say=say, axes=spoken))
        except OSError as error:
            raise UsageRefused(f"{host}:{port} cannot be used: {error.strerror}.") from None
        click.echo(f"Waiting for a program at {address.url(behind.port)}.", err=True)
        say(f"Velocity references are read in {spoken.meaning}. --axes {spoken.other}: the other.")
        outcome = _evaluate(run, RosProgram(behind, optics, arm), out, quiet=as_json)
        behind.publish_result(result_message(outcome))
    _report(run, outcome, out, as_json=as_json)


@bridge.command()
@benchmark_argument
@bridged_run_options
@_listening_options(ARDUPILOT_PORT, word="UDP port", within_s=30.0, what="frame")
@click.option(
    "--start",
    type=click.Choice(["armed", "connected"]),
    default="armed",
    show_default=True,
    help="Hold the vehicle until ArduSub drives a thruster, or until it has the first state.",
)
@json_option
def ardusub(  # noqa: PLR0913  # one argument per option
    *,
    benchmark: str,
    pairs: tuple[str, ...],
    config: Path | None,
    seed: int | None,
    trials: int | None,
    out: Path | None,
    host: str,
    port: int,
    answer_within: float,
    start: str,
    as_json: bool,
) -> None:
    """Evaluate ArduSub on a BlueROV2 Heavy, over ArduPilot's JSON interface for physics.

    ArduSub takes the place of position and velocity controller: each of its frames is one physics
    step, of 0.0025 s unless physics_step_s says otherwise. Start it with --model JSON:127.0.0.1
    and the frame vectored_6dof. docs/bridges.md has the rest.

    \b
    Examples:
      seamark bridge ardusub currents-v1 --set levels=0.2 --out result
    """
    from seamark.bridge.ardusub.link import Link
    from seamark.bridge.ardusub.program import ArduSub
    from seamark.cli.configuration import read_settings

    given = read_settings(config, pairs)
    missing = [f"{key}={value}" for key, value in ARDUSUB_SETTINGS.items() if key not in given]
    all_pairs = (*pairs, *missing)
    run = _local_run(benchmark, "ardusub", all_pairs, config, trials=trials, seed=seed)
    _refuse_other_vehicles(run)
    say = _say(quiet=as_json)
    with ExitStack() as stack:
        try:
            link = stack.enter_context(Link(host, port, answer_within_s=answer_within, say=say))
        except OSError as error:
            raise UsageRefused(f"{host}:{port} cannot be used: {error.strerror}.") from None
        click.echo(f"Waiting for ArduPilot at UDP {_shown(host)}:{link.port}.", err=True)
        program = ArduSub(link, wait_for_arming=start == "armed", say=say)
        outcome = _evaluate(run, program, out, quiet=as_json)
    _report(run, outcome, out, as_json=as_json)


def _refuse_other_vehicles(run: LocalRun) -> None:
    from seamark.bridge.ardusub.motors import VEHICLE

    others = {*_restored(run).vehicles()} - {VEHICLE}
    if others:
        raise UsageRefused(
            f"ArduSub drives the vehicle {VEHICLE}, not {', '.join(sorted(others))}."
        )


def _refuse_without_websockets() -> None:
    from seamark.cli.extras import install_line, missing

    if missing(["websockets"]):
        raise UsageRefused(f"This bridge needs a further package: {install_line('ros')}.")


def _refuse_what_a_server_decides() -> None:
    """Refuse options that have no meaning for a run on a server."""
    context = click.get_current_context()
    for name in ("real_time", "answer_within", "out"):
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            option = f"--{name.replace('_', '-')}"
            raise UsageRefused(f"{option} is for a run on this machine; leave it out.")


def _shown(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def _say(*, quiet: bool) -> Say:
    """Return the function that prints what happens at the connection."""

    def say(sentence: str) -> None:
        from seamark.sandbox.printable_text import printable_text

        if not quiet:
            click.echo(printable_text(sentence), err=True)

    return say


def _local_run(
    benchmark: str,
    name: str,
    pairs: Sequence[str],
    file: Path | None,
    *,
    trials: int | None,
    seed: int | None,
) -> LocalRun:
    """Return the run as the options describe it; refuses a benchmark of trackers."""
    from seamark.cli.configuration import benchmark_of, run_configuration_of
    from seamark.sim.engine.seeds import SEED_MAX

    role = benchmark_of(benchmark).role
    if role != "controller":
        raise UsageRefused(f"{benchmark} evaluates a {role}; a bridge connects a controller.")
    return LocalRun(
        benchmark=benchmark,
        config=run_configuration_of(benchmark, file, tuple(pairs), None),
        controller=name,
        role=role,
        program=None,
        seed=secrets.randbelow(SEED_MAX + 1) if seed is None else seed,
        trials=trials or 1,
    )


def _restored(run: LocalRun) -> ExperimentSettings:
    from seamark.sim import registry
    from seamark.sim.settings.experiment import ExperimentSettings

    config = registry.benchmark(run.benchmark).restore(run.config)
    if not isinstance(config, ExperimentSettings):
        raise PlatformFailed(f"{run.benchmark} has no vehicle.")
    return config


def _evaluate(run: LocalRun, program: Program, out: Path | None, *, quiet: bool) -> RunOutcome:
    from seamark.cli.output_folder import OutputFolder
    from seamark.cli.simulator_loading import loading_shown
    from seamark.progress import Progress
    from seamark.sim.recording import telemetry

    output = OutputFolder(out)
    what = f"{run.controller}, seed {run.seed}, trials {run.trials}"
    output.comments = [what, telemetry.units()]
    with Progress(run.benchmark, quiet=quiet) as bar, loading_shown(bar):
        from seamark.worker.evaluation.local import Callbacks, evaluate_connected

        callbacks = Callbacks(
            rows=output.add_rows,
            progress=lambda p: bar.show(p.fraction, f"{p.t_simulated:.0f} s simulated"),
        )
        try:
            outcome = evaluate_connected(
                *(run.benchmark, run.config, program),
                name=run.controller,
                seed=run.seed,
                trials=run.trials,
                callbacks=callbacks,
            )
        except KeyboardInterrupt:
            output.save(run.benchmark, None)
            click.echo("Stopped." + (f" Partial data: {out}" if out else ""), err=True)
            exit_with(INTERRUPTED)
    output.save(run.benchmark, outcome)
    return outcome


def _report(run: LocalRun, outcome: RunOutcome, out: Path | None, *, as_json: bool) -> None:
    report(run, outcome, out, as_json=as_json)
    exit_with(0 if outcome.failure is None else 1)
