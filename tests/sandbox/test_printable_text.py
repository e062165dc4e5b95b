import pytest

from seamark.sandbox.printable_text import printable_text, visible_text


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain – ü 水 🚀\n\ttab", "plain – ü 水 🚀\n\ttab"),
        ("two\r\nlines", "two\nlines"),
        ("\x1b[2J", r"\x1b[2J"),
        ("\x1b]0;title\x07", r"\x1b]0;title\x07"),
        ("\x1b]52;c;cm0gLXJm\x1b\\", r"\x1b]52;c;cm0gLXJm\x1b" + "\\"),
        ("\x9b31m", r"\x9b31m"),
        ("over\rwritten\b", r"over\rwritten\x08"),
        ("a\u202eb\u2066c\u200fd", r"a\u202eb\u2066c\u200fd"),
        ("\u2028\x85\0", r"\u2028\x85\x00"),
        ("\ud800\U000e0041", r"\ud800\U000e0041"),
    ],
)
def test_what_would_act_on_a_terminal_or_reader_is_shown_as_an_escape(
    text: str, shown: str
) -> None:
    assert printable_text(text) == shown


def test_visible_text_loses_what_a_name_does_not_show() -> None:
    assert visible_text("a\u202eb\u2066\u200f\u2028\x1b\0\n\ud800c é水🚀") == "abc é水🚀"
    assert visible_text("two\n\tlines\r", keep="\n\t") == "two\n\tlines"
