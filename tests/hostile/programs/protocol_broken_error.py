"""Sends an error that is wrong inside."""

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
        for sequence in range(64):
            os.write(protocol(), struct.pack("<cB2xI", b"x", 1, sequence) + b"zz")
        return [0.0, 0.0, 0.0, 0.0]
