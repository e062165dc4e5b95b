"""Sandboxes are tried once for a command, from its beginning, and only if it needs one."""

import pytest

from seamark.cli import solutions
from seamark.failures import PlatformFailed
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.probing import beside
from seamark.sandbox.probing.probes import Finding, IsolationReport
from seamark.sim.registry import DEFAULT_BENCHMARK


@pytest.fixture
def reports(monkeypatch: pytest.MonkeyPatch) -> list[IsolationReport]:
    """What the next probes find, instead of attacking real boxes."""
    reports: list[IsolationReport] = []
    monkeypatch.setattr(beside, "probe", lambda: reports[0])
    return reports


@pytest.mark.usefixtures("reports")
def test_what_needs_no_box_is_not_probed_for() -> None:
    with solutions.probing(needed=False) as isolation:  # there is no report to find
        assert isolation(DEFAULT_BENCHMARK) is IsolationLevel.NONE


def test_a_command_gets_the_level_that_the_probes_found(reports: list[IsolationReport]) -> None:
    reports.append(IsolationReport(IsolationLevel.MEDIUM))

    with solutions.probing(needed=True) as isolation:
        assert isolation(DEFAULT_BENCHMARK) is IsolationLevel.MEDIUM


def test_a_machine_without_isolation_is_refused_with_the_reason(
    reports: list[IsolationReport],
) -> None:
    missing = Finding("bubblewrap", ok=False, why="it is not installed")
    reports.append(IsolationReport(IsolationLevel.NONE, (missing,)))

    with (
        solutions.probing(needed=True) as isolation,
        pytest.raises(PlatformFailed, match="bubblewrap: it is not installed"),
    ):
        isolation(DEFAULT_BENCHMARK)
