"""How the processes of a worker learn that it shuts down."""

import signal
import threading

from seamark.worker.ipc.process_control import die_with_parent


class ShuttingDown(Exception):
    """The worker shuts down: what is under way returns to its queue, and counts as no failure."""


def follow_worker(parent: int) -> threading.Event:
    """Bind this side process to its worker; the event is set when the worker shuts down."""
    die_with_parent(parent)
    stopping = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stopping.set())
    return stopping
