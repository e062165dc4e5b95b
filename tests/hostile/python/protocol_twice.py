"""Answers more than once."""

import struct
import os


def protocol():
    return next(fd for fd in range(3, 256) if is_open(fd))


def is_open(fd):
    try:
        os.fstat(fd)
    except OSError:
        return False
    return True


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        frame = struct.pack("<cB2xI4d", b"c", 1, 3 + self.count, 0, 0, 0, 0)
        self.count += 1
        for _ in range(2):
            os.write(protocol(), frame)
        return [0.0, 0.0, 0.0, 0.0]
