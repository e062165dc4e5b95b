"""Speaks without being asked."""

import threading
import time
import os


def protocol():
    return next(fd for fd in range(3, 256) if is_open(fd))


def is_open(fd):
    try:
        os.fstat(fd)
    except OSError:
        return False
    return True


def chatter():
    while True:
        time.sleep(0.02)
        os.write(protocol(), b"chatter!")


class Controller:
    def __init__(self, config):
        threading.Thread(target=chatter, daemon=True).start()

    def step(self, observation):
        time.sleep(0.05)
        return [0.0, 0.0, 0.0, 0.0]
