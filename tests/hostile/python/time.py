"""Takes longer than it may."""

import os
import re
import signal
import threading
from time import sleep

HELD = ()


def answer_late(observation):
    """Answers after the limit."""
    sleep(2.0)  # well above: time that a busy host gives to others does not count


def deadlock(observation):
    """Waits for itself."""
    lock = threading.Lock()
    with lock, lock:
        pass


def ignore_signals(observation):
    """Cannot be asked to end."""
    for name in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
        signal.signal(name, signal.SIG_IGN)
    while True:
        pass


def sleep_step(observation):
    """Sleeps."""
    sleep(60)


def spin_big_integer(observation):
    """Holds the interpreter's lock in one instruction."""
    return 3 ** (10**9)


def spin_children(observation):
    """Burns CPU time in children."""
    for _ in range(3):
        if os.fork() == 0:
            while True:
                pass
    os.wait()


def spin_regex(observation):
    """A regular expression of exponential cost."""
    re.match(r"(a+)+$", "a" * 40 + "b")


def spin_step(observation):
    """Never answers."""
    while True:
        pass


def stop_itself(observation):
    """Stops itself."""
    os.kill(os.getpid(), signal.SIGSTOP)


class Endless(Exception):
    def __str__(self):
        while True:
            pass


def text_of_error(observation):
    """An exception that never says what it is."""
    raise Endless
