"""Whatever bytes a program sends, they are a message of the protocol or refused with a reason."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.languages.inside.wire import VERSION
from seamark.sandbox.protocol import messages
from seamark.sandbox.protocol.messages import MessageInvalid


@given(data=st.binary(max_size=200), sequence=st.integers(0, 2**32 - 1))
def test_any_bytes_are_an_answer_to_the_request_or_refused(data, sequence) -> None:
    with contextlib.suppress(MessageInvalid):
        message_type = messages.check(data, messages.COMMAND + messages.FAILED, sequence)

        assert data[:1] == message_type
        assert data[1] == VERSION
        assert int.from_bytes(data[4:8], "little") == sequence


@given(body=st.binary(max_size=400))
def test_any_error_message_is_shown_without_control_characters_or_refused(body) -> None:
    with contextlib.suppress(MessageInvalid):
        failure = messages.failure(messages.message(messages.FAILED, 1, body))

        assert all(c.isprintable() or c in "\n\t" for c in failure.sentence + failure.traceback)


@given(
    message_type=st.sampled_from([b"c", b"k", b"q"]),
    asked=st.integers(0, 2**32 - 1),
    answered=st.integers(0, 2**32 - 1),
)
def test_an_answer_to_another_request_is_refused(message_type, asked, answered) -> None:
    data = messages.message(message_type, answered)

    if asked == answered:
        assert messages.check(data, message_type, asked) == message_type
    else:
        with pytest.raises(MessageInvalid):
            messages.check(data, message_type, asked)
