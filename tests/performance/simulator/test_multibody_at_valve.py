"""The minute at the valve whose cost is published does what it should."""

import pytest

from performance.simulator.multibody_at_valve import AtValve, in_current


@pytest.mark.slow
def test_jaws_with_the_inertia_of_their_motors_hold_still_while_they_turn_the_valve() -> None:
    task = AtValve()

    task.run(in_current(0))

    assert task.q[-1] > 1.5
    assert task.slack < 2e-3
