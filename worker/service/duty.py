"""Which workers look after what all share: each for itself would be a thousand looking at the same.

A few rather than one: the death of a worker is then noticed as fast as before, by another that has
watched the leases all the time.
"""

from contextlib import suppress

from redis import Redis
from redis.exceptions import LockError, RedisError
from redis.lock import Lock

HOLDERS = 3
KEY = "seamark:duty:{}{}"


class Duty:
    """One of `HOLDERS` locks, which a process keeps as long as it asks often enough.

    Parameters
    ----------
    rights
        Names a duty that not every worker has the rights for.
    kept_s
        Time after which a silent holder loses its lock.
    """

    def __init__(self, redis: "Redis", rights: str = "", *, kept_s: float) -> None:
        self._locks = [
            redis.lock(KEY.format(rights, number), timeout=kept_s, blocking=False)
            for number in range(HOLDERS)
        ]
        self._lock: Lock | None = None

    def is_mine(self) -> bool:
        """Take or keep a lock; True without a broker: rather too many look than nobody."""
        try:
            if self._lock is not None and _kept(self._lock):
                return True
            self._lock = next((lock for lock in self._locks if lock.acquire()), None)
        except RedisError:
            return True
        return self._lock is not None

    def give_up(self) -> None:
        """Leave the lock to another process at once."""
        if self._lock is not None:
            with suppress(RedisError):  # no longer ours, or the broker is away
                self._lock.release()
            self._lock = None


def _kept(lock: Lock) -> bool:
    try:
        return bool(lock.reacquire())
    except LockError:
        return False
