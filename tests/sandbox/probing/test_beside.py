"""Probes beside the caller: the report is the same, whoever makes it."""

import os

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.probing import beside
from seamark.sandbox.probing.probes import Finding, IsolationReport


def test_another_process_makes_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        beside,
        "probe",
        lambda: IsolationReport(IsolationLevel.STRONG, (Finding(str(os.getpid()), ok=True),)),
    )

    with beside.probing() as report:
        made = report()

    assert made.level is IsolationLevel.STRONG
    assert made.findings[0].name != str(os.getpid())


def test_a_report_that_cannot_be_made_there_is_made_here(monkeypatch: pytest.MonkeyPatch) -> None:
    caller = os.getpid()

    def probe() -> IsolationReport:
        if os.getpid() != caller:
            raise SandboxBroken("no box starts")
        return IsolationReport(IsolationLevel.MEDIUM)

    monkeypatch.setattr(beside, "probe", probe)

    with beside.probing() as report:
        assert report().level is IsolationLevel.MEDIUM
