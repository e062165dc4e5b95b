"""Head and tail of the output, in bounded memory."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.protocol.head_tail import HeadTail

KEEP = 20


def printed(parts: list[bytes]) -> HeadTail:
    kept = HeadTail(KEEP)
    for part in parts:
        kept.feed(part)
    return kept


@given(parts=st.lists(st.binary(max_size=40)))
def test_the_result_does_not_depend_on_how_the_output_is_split(parts) -> None:
    assert printed(parts).text() == printed([b"".join(parts)]).text()


@given(text=st.binary(max_size=KEEP))
def test_output_within_the_limit_is_kept_whole(text) -> None:
    kept = printed([text])

    assert (kept.text(), kept.dropped) == (text, 0)


@given(text=st.binary(min_size=KEEP + 1, max_size=500))
def test_of_longer_output_head_tail_and_a_count_are_kept(text) -> None:
    kept = printed([text])

    assert kept.text().startswith(text[: KEEP // 2])
    assert kept.text().endswith(text[-KEEP // 2 :])
    assert kept.dropped == len(text) - KEEP
    assert f"{kept.dropped} bytes dropped".encode() in kept.text()


@pytest.mark.slow
@given(size=st.integers(0, 10_000), pieces=st.integers(1, 50))
def test_a_flood_of_output_uses_bounded_memory(size, pieces) -> None:
    kept = printed([b"x" * size] * pieces)

    assert len(kept.text()) <= KEEP + 60
    assert kept.total == size * pieces
