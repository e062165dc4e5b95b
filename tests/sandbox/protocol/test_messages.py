"""Whatever bytes a program sends, it is a frame of the protocol or refused with a sentence."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.messages import FrameInvalid


@given(data=st.binary(max_size=200), sequence=st.integers(0, 2**32 - 1))
def test_any_bytes_are_an_answer_to_the_question_or_refused(data, sequence) -> None:
    with contextlib.suppress(FrameInvalid):
        kind = messages.check(data, messages.ANSWER + messages.FAILED, sequence)

        assert data[:1] == kind
        assert data[1] == messages.VERSION
        assert int.from_bytes(data[4:8], "little") == sequence


@given(body=st.binary(max_size=400))
def test_any_error_frame_is_shown_without_control_characters_or_refused(body) -> None:
    with contextlib.suppress(FrameInvalid):
        said = messages.failure(messages.frame(messages.FAILED, 1, body))

        assert all(c.isprintable() or c in "\n\t" for c in said.sentence + said.traceback)


@given(
    kind=st.sampled_from([b"c", b"k", b"q"]),
    asked=st.integers(0, 2**32 - 1),
    answered=st.integers(0, 2**32 - 1),
)
def test_an_answer_to_another_question_is_refused(kind, asked, answered) -> None:
    data = messages.frame(kind, answered)

    if asked == answered:
        assert messages.check(data, kind, asked) == kind
    else:
        with pytest.raises(FrameInvalid):
            messages.check(data, kind, asked)
