import pytest

from seamark.programs.failure_reasons import DESCRIPTIONS, FailureReason, describe
from seamark.sandbox.outcome import Verdict


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


@pytest.mark.parametrize(
    ("sentence", "says", "page"),
    [
        ("ModuleNotFoundError: No module named 'torch' (line 1 of a.py)", "ONNX", "/docs/box"),
        ("ModuleNotFoundError: No module named 'keras.layers' (line 1)", "ONNX", "/docs/box"),
        ("ModuleNotFoundError: No module named 'pandas'; the box", "archive", "/docs/box"),
        ("ModuleNotFoundError: No module named 'requests'; the box", "no network", "/docs/box"),
        ("socket.gaierror: [Errno -2] Name or service not known", "no network", "/docs/box"),
        ("urllib.error.URLError: <urlopen error [Errno -3]", "no network", "/docs/box"),
        ("urlread: Couldn't resolve host name (line 2 of a.m)", "no network", "/docs/box"),
        ("The program (import and __init__) used 10 s of CPU", "beforehand", ""),
        ("The FMU (loading and instantiation) did not return", "beforehand", ""),
        ("ValueError: no gain (line 3 of a.py)", "traceback", ""),
    ],
)
def test_the_remedy_and_its_page_follow_from_what_went_wrong(
    sentence: str, says: str, page: str
) -> None:
    started = "used" in sentence or "did not return" in sentence
    reason = FailureReason.TIME_LIMIT if started else FailureReason.USER_ERROR

    described = describe(reason, sentence=sentence)

    assert says in described["remedy"]
    assert described["page"] == page


def test_a_missing_header_leads_to_the_list_of_libraries() -> None:
    sentence = "a.cpp:1:10: fatal error: torch/script.h: No such file or directory"

    described = describe(FailureReason.COMPILE_ERROR, sentence=sentence)

    assert "archive" in described["remedy"]
    assert described["page"] == "/docs/box"
