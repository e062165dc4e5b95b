"""Thruster faults: less thrust, or delayed thrust, from a given time on."""

from collections import deque
from dataclasses import dataclass, field


@dataclass(slots=True, kw_only=True)
class ThrusterFault:
    """A fault of one thruster during one level.

    `efficiency` is the remaining share of the steady thrust, 0 for a dead thruster. Delay and start
    are counted in physics steps and take effect with the next command.
    """

    thruster: int
    efficiency: float
    delay_steps: int
    from_step: int
    _pending: deque[tuple[int, float]] = field(default_factory=deque)
    _applied: float = 0.0

    def reset(self) -> None:
        """Discard the delayed commands."""
        self._pending.clear()
        self._applied = 0.0

    def apply(self, step: int, commanded: float) -> float:
        """Return the steady thrust [N] applied when `commanded` is commanded at a physics step."""
        if step < self.from_step:
            self._applied = commanded
            return commanded
        self._pending.append((step + self.delay_steps, commanded))
        while self._pending and self._pending[0][0] <= step:
            self._applied = self._pending.popleft()[1]
        return self.efficiency * self._applied
