"""A thruster that fails: it gives less than it should, or later, from some time on."""

from collections import deque
from dataclasses import dataclass, field


@dataclass(slots=True, kw_only=True)
class ThrusterFault:
    """One broken thruster of one level.

    `efficiency` is the share of the steady thrust that is left, 0 for a dead thruster. Delay
    and start are counted in physics steps and take effect when the next command arrives.
    """

    thruster: int
    efficiency: float
    delay_steps: int
    from_step: int
    _due: deque[tuple[int, float]] = field(default_factory=deque)
    _given: float = 0.0

    def reset(self) -> None:
        """Forget the commands that are under way."""
        self._due.clear()
        self._given = 0.0

    def given(self, tick: int, wanted: float) -> float:
        """Return the steady thrust that it gives when another is commanded at a tick [N]."""
        if tick < self.from_step:
            self._given = wanted
            return wanted
        self._due.append((tick + self.delay_steps, wanted))
        while self._due and self._due[0][0] <= tick:
            self._given = self._due.popleft()[1]
        return self.efficiency * self._given
