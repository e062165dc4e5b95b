"""When a queued run will start, from the wall times that the runs before it are expected to take.

Pure functions, in seconds.
"""

import heapq
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

OTHERS = ""  # the owner of runs of which only the number is known
Job = tuple[str, float]  # owner, wall time [s] that the run is expected to take


@dataclass(frozen=True, slots=True)
class Slots:
    """What runs now, with the wall times [s] that are left, and where."""

    count: int
    running: Sequence[Job]
    limit: int  # of the running runs of one owner


def start_s(slots: Slots, ahead: Sequence[Job], owner: str) -> float:
    """Return when a run of `owner` starts, after the runs ahead of it.

    As in the queue, the owner with the fewest running runs goes first, and else this order holds;
    runs of nobody in particular (`OTHERS`) have their position in the order.
    """
    now, waiting = 0.0, [*ahead, (owner, 0.0)]
    live = [(left, name) for name, left in slots.running]
    heapq.heapify(live)
    busy = Counter(name for _, name in live)
    while True:
        while len(live) < slots.count:
            at = _next(waiting, busy, slots.limit)
            if at is None:
                break
            if at == len(waiting) - 1:
                return now
            name, wall_s = waiting.pop(at)
            busy[name] += 1
            heapq.heappush(live, (now + wall_s, name))
        if not live:  # no slot at all
            return now
        now, ended = heapq.heappop(live)
        busy[ended] -= 1


def _next(waiting: Sequence[Job], busy: Mapping[str, int], limit: int) -> int | None:
    """Return which of the waiting runs starts next; None if all owners are at the limit."""
    if waiting[0][0] == OTHERS:
        return 0
    allowed = [
        (busy[name], at)
        for at, (name, _) in enumerate(waiting)
        if name != OTHERS and busy[name] < limit
    ]
    return min(allowed)[1] if allowed else None


def start_of_many_s(slots: Slots, wall_s: float, owner: str, own_s: float) -> float:
    """Return when a run of `owner` starts, after so many runs that only their sum matters.

    Parameters
    ----------
    wall_s, own_s
        What all runs ahead take one after the other, and those of the owner among them.
    """
    every = [left for _, left in slots.running]
    own = [left for name, left in slots.running if name == owner]
    return max(_free_s(every, slots.count, wall_s), _free_s(own, slots.limit, own_s))


def _free_s(left: Sequence[float], count: int, wall_s: float) -> float:
    """Return when a slot is free, if each takes part in the work as soon as it is free itself."""
    free_at = sorted([*left, *[0.0] * (count - len(left))])
    level = free_at[0]
    for shared_by, next_at in enumerate(free_at[1:], start=1):
        room = shared_by * (next_at - level)
        if wall_s <= room:
            return level + wall_s / shared_by
        wall_s, level = wall_s - room, next_at
    return level + wall_s / len(free_at)
