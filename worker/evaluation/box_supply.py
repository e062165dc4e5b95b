"""Warm boxes for the trials of one run that are processes side by side.

A box belongs to this process, which lends it to the trial's. While the trials run, those for the
next ones start.
"""

from seamark.sandbox.pool import Loan, Pool


class Supply:
    """What one run takes from the pool of its process."""

    def __init__(self, pool: Pool, language: str, most: int) -> None:
        """`most` boxes wait at a time."""
        self._pool = pool
        self._language = language
        self._most = most

    def lend(self) -> Loan:
        """Return a box for the next trial, or none if none waits: the trial then makes its own."""
        return self._pool.lend(self._language, 1)

    def provide(self, trials: int) -> None:
        """Start what is missing for so many trials that are to come."""
        self._pool.stock(self._language, min(self._most, trials))
        self._pool.refill()
