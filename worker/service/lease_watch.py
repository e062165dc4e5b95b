"""Which leases are no longer renewed, whatever the clocks of the hosts say.

A lease ends at a time of the wall clock, and wall clocks jump: an hour ahead, and all live runs
would be taken from their workers; an hour back, and the runs of dead workers would wait for it.
"""

import time
from collections.abc import Mapping
from typing import NamedTuple


class _Observed(NamedTuple):
    """The end of a lease as last seen."""

    end: float  # [s] of the wall clock
    since_s: float  # monotonic; since when it is the same


class LeaseWatch:
    """Observes leases from sweep to sweep, by this process's monotonic clock.

    Parameters
    ----------
    lease_s
        How long a lease is granted for.
    renewal_s
        How often its holder renews it.
    """

    def __init__(self, *, lease_s: float, renewal_s: float) -> None:
        self._lease_s = lease_s
        self._patience_s = 2 * renewal_s
        self._seen: dict[int, _Observed] = {}  # by the id of the lease

    def abandoned(self, leases: Mapping[int, float], *, now_s: float) -> dict[int, float]:
        """Return the leases whose holders are gone.

        These have ended and missed two renewals before our eyes, or were not renewed for as long as
        they were granted for.

        Parameters
        ----------
        leases
            All that are held: id -> the end of the lease [s, of the wall clock].
        now_s
            The monotonic time.
        """
        self._seen = {key: self._observed(key, end, now_s) for key, end in leases.items()}
        wall_s = time.time()
        return {
            key: seen.end
            for key, seen in self._seen.items()
            if now_s - seen.since_s >= (self._patience_s if seen.end < wall_s else self._lease_s)
        }

    def _observed(self, key: int, end: float, now_s: float) -> _Observed:
        seen = self._seen.get(key)
        return seen if seen is not None and seen.end == end else _Observed(end, now_s)
