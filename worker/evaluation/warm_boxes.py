"""Warm boxes for the parallel trials of one run.

The process of the run owns the boxes and leases one to the process of each trial. While trials
run, the boxes for the next ones start.
"""

from seamark.sandbox.pool import BoxLease, Pool


class WarmBoxes:
    """The boxes that one run takes from the pool of its process."""

    def __init__(self, pool: Pool, language: str, waiting_max: int) -> None:
        self._pool = pool
        self._language = language
        self._waiting_max = waiting_max

    def lease(self) -> BoxLease:
        """Return a box for the next trial, or none if none is waiting: the trial starts its own."""
        return self._pool.lease(self._language, 1)

    def start(self, trials: int) -> None:
        """Start the boxes that are missing for so many trials to come."""
        self._pool.stock(self._language, min(self._waiting_max, trials))
        self._pool.refill()
