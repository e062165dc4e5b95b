"""How long the host kept a program from running: time that does not count as the program's."""

from seamark.sandbox.isolation.process_tree import ProcessTree


class Starvation:
    """Measures a lower bound from now on.

    A thread that is ready to run waits for other threads of its box, or for others on the host. It
    waits for its own box no longer than that runs: the longest wait of a thread, less the CPU time
    of the whole box, is due to the host, whatever a program does with its processes. For a single
    thread this falls short by the CPU time that it used.
    """

    def __init__(self, tree: ProcessTree) -> None:
        self._tree = tree
        self._cpu_before_s = tree.cpu_s()
        self._before_s = tree.run_queue_waits_s()

    def so_far_s(self) -> float:
        """Return for how long at least the box was ready to run, and nothing of it ran [s]."""
        used_s = self._tree.cpu_s() - self._cpu_before_s
        waits_s = self._tree.run_queue_waits_s()
        longest_s = max(
            (waits_s[thread] - self._before_s.get(thread, 0.0) for thread in waits_s), default=0.0
        )
        return max(longest_s - used_s, 0.0)
