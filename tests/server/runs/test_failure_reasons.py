import pytest

from seamark.sandbox.outcome import Verdict
from seamark.server.runs.failure_reasons import DESCRIPTIONS, FailureReason, describe


@pytest.mark.parametrize("verdict", [verdict for verdict in Verdict if verdict is not Verdict.OK])
def test_every_failure_of_a_program_is_a_failure_reason(verdict: Verdict) -> None:
    assert FailureReason(verdict).value == verdict.value


def test_every_failure_reason_has_a_description() -> None:
    assert set(DESCRIPTIONS) == set(FailureReason)


def test_the_sentence_of_the_sandbox_replaces_the_general_one() -> None:
    described = describe(FailureReason.USER_ERROR, sentence="ValueError: no gain (line 3)")

    assert described["sentence"] == "ValueError: no gain (line 3)"
    assert described["title"] == DESCRIPTIONS[FailureReason.USER_ERROR].title


def test_an_access_outside_of_the_sandbox_is_explained() -> None:
    described = describe(FailureReason.USER_ERROR, sentence="FileNotFoundError: /etc/x (line 3)")

    assert "no network" in described["remedy"]
