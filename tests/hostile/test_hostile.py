"""Every hostile program ends as its table says and achieves nothing.

At the compiler, at the start, while it runs, at its end: programs of all roles in all languages.
"""

import re

import numpy as np
import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, Verdict
from seamark.sandbox.protocol.answers import Loss
from tests.hostile.corpus import CASES, ROLES, TABLES, case, programs

pytestmark = pytest.mark.host

each_case = pytest.mark.parametrize("program", CASES, ids=str)
# Medium isolation has all layers except the control groups: the programs that these would stop run
# again, and one program of every other group.
STOPPED_BY_CGROUPS = re.compile(
    r"exhaustion_|time_|processes_(fork|threads|shell|system|kill|signal)"
)
GROUPS = {name.split("_", 1)[0]: name for name in sorted(TABLES["python"], reverse=True)}
SEEING_AT_MEDIUM = re.compile(
    r"keeps_every_image.py|sleeps.py|spins.py|unprotects_image|resizes_images.c|writes_image.c"
    r"|changes_image.m"
)
AT_MEDIUM = [
    program
    for program in CASES
    if (
        SEEING_AT_MEDIUM.match(program.name)
        if program.folder in ROLES
        else STOPPED_BY_CGROUPS.match(program.name) or program.name in GROUPS.values()
    )
    and program.folder in (*ROLES, "python")
]


def got(outcome: Outcome) -> str:
    """Return what an attack printed about its success."""
    line = re.search(rb"GOT.*", outcome.output)
    return line[0].decode("utf-8", "replace") if line else ""


@pytest.mark.parametrize("folder", TABLES)
def test_every_program_has_an_expectation_and_every_expectation_a_program(folder) -> None:
    assert programs(folder) == set(TABLES[folder])


@each_case
def test_a_hostile_program_ends_as_the_table_says(program, run_case, isolation, secret) -> None:
    expected = program.expected
    # Without control groups nothing counts for the whole box: it is stopped all the same, but the
    # verdict depends on how the program reacts to the refusal.
    at_medium = expected.get("medium") if isolation is IsolationLevel.MEDIUM else None

    outcome, answers = run_case(program)

    assert got(outcome) == ""
    assert outcome.verdict == (at_medium or expected["verdict"]), outcome
    assert outcome.suspect_host == expected.get("waits", outcome.suspect_host)
    assert re.search(expected.get("says", ""), outcome.sentence), outcome.sentence
    assert secret.encode() not in outcome.output
    assert len(outcome.output) < 5000
    for path in ("/tmp/", "/box/native/runner.c:", "\x1b"):
        assert path not in outcome.sentence + outcome.traceback
    numbers = [answer for answer in answers if not isinstance(answer, Loss)]
    assert np.isfinite(np.array(numbers)).all()


@pytest.mark.slow
@pytest.mark.parametrize("program", AT_MEDIUM, ids=str)
def test_it_achieves_nothing_with_medium_isolation_either(program, run_case, isolation) -> None:
    if isolation is IsolationLevel.MEDIUM:
        pytest.skip("this host has medium isolation: it just ran")

    outcome, _ = run_case(program, at=IsolationLevel.MEDIUM)

    assert got(outcome) == ""
    assert outcome.verdict == program.expected["verdict"], outcome


@pytest.mark.parametrize("name", ["time_spin_init", "time_spin_reset", "time_spin_import"])
def test_a_program_that_used_up_its_cpu_time_is_to_blame_on_a_busy_host_too(name, run) -> None:
    outcome = run(name, limits=Limits(cpu_s=0.2, start_wall_s=60.0))

    assert outcome.verdict is Verdict.TIME_LIMIT
    assert not outcome.suspect_host


def test_a_traceback_has_the_line_of_the_program_and_no_frame_of_ours(run) -> None:
    line = case("values_set_observation").source.decode().splitlines().index(STATEMENT) + 1

    outcome = run("values_set_observation")

    assert f'File "values_set_observation.py", line {line}, in set_obs' in outcome.traceback
    assert STATEMENT.strip() in outcome.traceback
    assert "runner" not in outcome.traceback


STATEMENT = "    observation.t = 9.0"


def test_the_corpus_has_at_least_three_hundred_programs() -> None:
    assert len(CASES) >= 300
