import pytest

from seamark.programs.failure_hints import hint
from seamark.programs.role_names import with_role, without_role


@pytest.mark.parametrize(
    ("sentence", "named"),
    [
        ("The program was ended by SIGSEGV.", "The tracker was ended by SIGSEGV."),
        ("ValueError: no idea", "The tracker: ValueError: no idea"),
    ],
)
def test_a_sentence_is_about_one_program(sentence: str, named: str) -> None:
    assert with_role(sentence, "tracker") == named
    assert without_role(named) == sentence


def test_a_sentence_that_names_the_program_already_stays() -> None:
    sentence = "The detector answered with 99 detections; the limit is 32."

    assert with_role(sentence, "detector") == sentence


@pytest.mark.parametrize(
    "sentence",
    [
        "The program was ended by SIGSEGV: native code accessed invalid memory.",
        "ModuleNotFoundError: No module named 'torch'",
        "PermissionError: [Errno 13] Permission denied",
    ],
)
def test_the_hint_about_a_failure_is_the_same_for_every_program(sentence: str) -> None:
    assert hint(with_role(sentence, "detector")) == hint(sentence)
    assert hint(sentence).remedy
