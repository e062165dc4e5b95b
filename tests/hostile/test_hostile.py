"""Every hostile program gets the verdict of the table, and achieves nothing."""

import re
import tomllib
from pathlib import Path

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, Verdict
from tests.hostile.conftest import limits_for

pytestmark = pytest.mark.host

TABLE = tomllib.loads(Path(__file__).with_name("expectations.toml").read_text(encoding="utf-8"))
PROGRAMS = Path(__file__).with_name("programs")
# Medium isolation has all layers except the control groups: the programs that these would stop run
# again, and one program of every other group.
STOPPED_BY_CGROUPS = re.compile(
    r"exhaustion_|time_|processes_(fork|threads|shell|system|kill|signal)"
)
GROUPS = {name.split("_", 1)[0]: name for name in sorted(TABLE, reverse=True)}
AT_MEDIUM = sorted(
    {name for name in TABLE if STOPPED_BY_CGROUPS.match(name)} | set(GROUPS.values())
)


def got(outcome: Outcome) -> str:
    """Return what an attack printed about its success."""
    found = re.search(rb"GOT.*", outcome.output)
    return found[0].decode() if found else ""


def test_every_program_has_an_expectation_and_every_expectation_a_program() -> None:
    assert {path.stem for path in PROGRAMS.glob("*.py")} == set(TABLE)


@pytest.mark.parametrize("name", sorted(TABLE))
def test_a_hostile_program_ends_as_the_table_says(name, run, secret) -> None:
    expected = TABLE[name]

    outcome = run(name, limits=limits_for(expected))

    assert got(outcome) == ""
    assert outcome.verdict == expected["verdict"], outcome
    assert outcome.suspect_host == expected.get("waits", outcome.suspect_host)
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert secret.encode() not in outcome.output
    assert len(outcome.output) < 5000


@pytest.mark.slow
@pytest.mark.parametrize("name", AT_MEDIUM)
def test_it_achieves_nothing_with_medium_isolation_either(name, run, isolation) -> None:
    if isolation is IsolationLevel.MEDIUM:
        pytest.skip("this host has medium isolation: it just ran")
    expected = TABLE[name]

    outcome = run(name, at=IsolationLevel.MEDIUM, limits=limits_for(expected))

    assert got(outcome) == ""
    assert outcome.verdict == expected["verdict"], outcome


@pytest.mark.parametrize("name", ["time_spin_init", "time_spin_reset", "time_spin_import"])
def test_a_program_that_used_up_its_cpu_time_is_to_blame_on_a_busy_host_too(name, run) -> None:
    outcome = run(name, limits=Limits(cpu_s=0.5, start_wall_s=60.0))

    assert outcome.verdict is Verdict.TIME_LIMIT
    assert not outcome.suspect_host


def test_a_traceback_has_the_line_of_the_program_and_no_frame_of_ours(run) -> None:
    outcome = run("values_set_observation")

    assert 'File "values_set_observation.py", line 9, in step' in outcome.traceback
    assert "observation.t = 0.0" in outcome.traceback
    assert "runner" not in outcome.traceback
