"""What may wait in the broker for a connected program."""

import pytest

from seamark.server.messaging.bridge_sessions import PENDING_MAX
from seamark.worker.service.bridge_relay import PENDING_BYTES, _is_full


@pytest.mark.parametrize(
    ("sizes", "waiting", "full"),
    [
        ([PENDING_BYTES + 1], 0, False),  # the program has taken it
        ([PENDING_BYTES + 1], 1, True),
        ([PENDING_BYTES, 1], 1, False),
        ([PENDING_BYTES, 1], 2, True),
        ([10] * PENDING_MAX, PENDING_MAX - 1, False),
        ([10] * PENDING_MAX, PENDING_MAX, True),
    ],
)
def test_messages_wait_for_a_program_up_to_a_number_and_a_size(
    sizes: list[int], waiting: int, full: bool
) -> None:
    assert _is_full(sizes, waiting) is full
