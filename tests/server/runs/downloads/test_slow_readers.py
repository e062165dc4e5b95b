"""A slot that a slow reader does not keep from the others."""

from collections.abc import Generator

import pytest

from seamark.server.runs.downloads.slow_readers import (
    PATIENCE_S,
    Download,
    DownloadSlot,
    ReaderTooSlow,
    SlotTaken,
)


class Clock:
    """A clock that goes on when told to."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def _pieces(closed: list[str], name: str) -> Generator[bytes, None, None]:
    try:
        while True:
            yield bytes(1000)
    finally:
        closed.append(name)


def _taken(slot: DownloadSlot, closed: list[str], name: str) -> Download:
    download = slot.take().of(_pieces(closed, name))
    next(download)
    return download


def test_a_reader_who_takes_nothing_loses_the_place_and_its_memory_to_the_next() -> None:
    clock, closed = Clock(), list[str]()
    slot = DownloadSlot(clock=clock)
    slow = _taken(slot, closed, "slow")
    clock.now_s = PATIENCE_S - 1.0
    with pytest.raises(SlotTaken):
        slot.take()

    clock.now_s = PATIENCE_S + 1.0
    following = _taken(slot, closed, "following")

    assert closed == ["slow"]
    with pytest.raises(ReaderTooSlow):
        next(slow)
    slow.close()
    with pytest.raises(SlotTaken):
        slot.take()
    following.close()
    assert closed == ["slow", "following"]


def test_a_reader_who_takes_a_piece_now_and_then_loses_it_as_well() -> None:
    clock, closed = Clock(), list[str]()
    slot = DownloadSlot(clock=clock)
    slow = _taken(slot, closed, "slow")

    for at in range(8):
        clock.now_s = 10.0 * at
        next(slow)

    slot.take()
    assert closed == ["slow"]


def test_a_reader_who_reads_keeps_the_place_however_long_the_pieces_take() -> None:
    clock, closed = Clock(), list[str]()
    slot = DownloadSlot(clock=clock)

    def pieces() -> Generator[bytes, None, None]:
        for _ in range(10):
            clock.now_s += PATIENCE_S
            with pytest.raises(SlotTaken):
                slot.take()
            yield bytes(1000)
        closed.append("all")

    assert len(list(slot.take().of(pieces()))) == 10
    assert closed == ["all"]
    slot.take()
