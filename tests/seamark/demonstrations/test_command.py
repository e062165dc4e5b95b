"""`seamark demonstrations`: what it keeps, and what it refuses."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars
import pytest
from click.testing import Result

from seamark.demonstrations.episodes import Outcome, Task
from seamark.demonstrations.layouts import LAYOUTS
from seamark.demonstrations.recording import MOST_ATTEMPTS, Plan, Recording
from seamark.demonstrations.spool import Spool
from seamark.progress import Progress
from seamark.sim import registry

Written = Callable[..., Path]
Command = Callable[..., Result]
SHORT = ("--set", "levels=0,0.1", "--set", "level_duration_s=2", "--jobs", "1")
ARMED = [name for name in registry.BENCHMARKS if registry.benchmark(name).moves_arm]


def files_of(folder: Path) -> dict[str, bytes]:
    files = (file for file in sorted(folder.rglob("*")) if file.is_file())
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def plan_of(seed: int, **options: Any) -> Plan:
    task = Task(benchmark="valve-v1", settings={}, expert="scripted", reward="dense", dtype="f8")
    chosen = {"levels": 6, "episodes": 8, "only_successes": False} | options
    return Plan(task=task, first_seed=seed, **chosen)


@pytest.mark.slow
@pytest.mark.parametrize(
    "layout",
    [
        pytest.param(layout, marks=() if layout == "parquet" else pytest.mark.long)
        for layout in LAYOUTS
    ],
)
def test_the_bytes_do_not_depend_on_how_many_processes_write_them(
    written: Written, written_once: Written, layout: str
) -> None:
    one = files_of(written_once(layout))
    two = files_of(written(layout, "two", jobs=2))

    assert one == two
    assert len(one) >= 3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("benchmark", "expert"),
    [(name, expert) for name in ARMED for expert in registry.benchmark(name).built_in],
)
def test_every_benchmark_with_an_arm_has_demonstrations_of_its_experts(
    demonstrations: Command, tmp_path: Path, benchmark: str, expert: str
) -> None:
    out = tmp_path / "out"
    options = ("--episodes", "2", "--expert", expert, "--out", str(out), "--format", "parquet")

    ended = demonstrations(benchmark, *options, *SHORT, "--json")

    assert ended.exit_code == 0, ended.output
    told = json.loads(ended.stdout)
    assert (told["episodes"], told["attempts"], told["steps"]) == (2, 2, 80)
    assert json.loads((out / "seamark.json").read_text())["expert"] == expert
    assert polars.read_parquet(out / "steps" / "**" / "*.parquet")["action"].n_unique() > 10


def stored(spool: Spool, successes: set[int], count: int) -> None:
    """Have outcomes on the disk as if they were recorded."""
    for number in range(count):
        outcome = Outcome(
            number=number,
            seed=number,
            trial=0,
            level=0,
            current_m_s=0.0,
            steps=40,
            credit=float(number in successes),
            stages=0,
            success=number in successes,
        )
        spool.store(outcome, None)


def test_only_successes_are_the_first_ones_of_all_attempts(tmp_path: Path) -> None:
    plan = plan_of(1, episodes=2, only_successes=True)
    spool, shown = Spool(tmp_path / "out"), []
    spool.folder.mkdir()
    stored(spool, {3, 7, 8}, MOST_ATTEMPTS * 2)

    kept = Recording(plan, spool, LAYOUTS["parquet"], workers=1).run(
        lambda outcome, kept: shown.append((outcome.number, kept))
    )

    assert [outcome.number for outcome in kept] == [3, 7]
    assert shown == [*((n, 0) for n in range(3)), *((n, 1) for n in range(3, 7)), (7, 2)]


@pytest.mark.slow
def test_an_expert_that_hardly_ever_succeeds_is_said(
    demonstrations: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seamark.demonstrations.recording.MOST_ATTEMPTS", 2)
    options = ("--episodes", "1", "--successes", "--out", str(tmp_path / "out"))

    ended = demonstrations("valve-v1", *options, *SHORT)

    assert ended.exit_code == 2
    assert "The expert scripted succeeded in 0 of 2 attempts." in ended.output
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_an_interrupted_command_goes_on_where_it_was(
    written_once: Written, demonstrations: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    options = ("--format", "parquet", "--out", str(out), "--set", "images=both", *SHORT)
    show = Progress.show

    def interrupted(self: Progress, fraction: float, note: str = "", *, state: str = "") -> None:
        show(self, fraction, note, state=state)
        if note == "2 of 3 episodes":
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Progress, "show", interrupted)
        first = demonstrations("valve-v1", "--episodes", "3", *options)
    kept = tmp_path / "out.part" / "000001.npz"
    assert (first.exit_code, out.exists(), kept.exists()) == (130, False, True)
    assert f"{out}.part has the episodes so far" in first.output
    other = demonstrations("valve-v1", "--episodes", "3", *options, "--seed", "5")
    assert other.exit_code == 2
    assert "an interrupted command with other options" in other.output
    written_at = kept.stat().st_mtime_ns
    seen: list[int] = []
    with monkeypatch.context() as patch:
        patch.setattr(Progress, "show", lambda *_, **__: seen.append(kept.stat().st_mtime_ns))
        again = demonstrations("valve-v1", "--episodes", "3", *options)

    assert again.exit_code == 0
    assert set(seen) == {written_at}
    assert files_of(out) == files_of(written_once("parquet"))
    assert not (tmp_path / "out.part").exists()


def test_the_seed_of_the_reference_trials_is_left_out() -> None:
    seeds = [attempt.seed for attempt in plan_of(2024).attempts()]

    assert seeds == [2024, 2025, 2027, 2028, 2029, 2030, 2031, 2032]


def test_the_levels_take_turns() -> None:
    levels = [attempt.level for attempt in plan_of(1).attempts()]

    assert levels == [0, 1, 2, 3, 4, 5, 0, 1]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("currents-v2",), "currents-v2 has no demonstrations. Benchmarks that have some: mission"),
        (("turn-v9",), "There is no benchmark turn-v9"),
        (("valve-v1", "--expert", "oracle"), "There is no built-in solution oracle. Available: re"),
        (("valve-v1", "--seed", "2147483647"), "the seed of the last episode would be beyond"),
        (("valve-v1", "--set", "images=none,"), "images"),
        (("valve-v1", "--set", "control_period_s=0.03"), "LeRobot counts whole frames a second"),
        (("valve-v1", "--out", "/proc/nothing"), "/proc/nothing cannot be written"),
        (("valve-v1", "--out", "."), " is there already. Choose another folder."),
    ],
)
def test_wrong_usage_ends_with_a_message_and_leaves_nothing(
    demonstrations: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    says: str,
) -> None:
    (tmp_path / "mine.txt").touch()
    monkeypatch.chdir(tmp_path)

    ended = demonstrations(*arguments, "--episodes", "2")

    assert ended.exit_code == 2
    assert says in ended.output
    assert [*tmp_path.iterdir()] == [tmp_path / "mine.txt"]


def test_without_its_packages_a_layout_says_what_to_install(
    demonstrations: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seamark.cli.extras.missing", list)

    ended = demonstrations("valve-v1", "--format", "minari")

    assert ended.exit_code == 2
    assert 'needs further packages: pip install "seamark[demonstrations]' in ended.output
