"""Uses descriptors that were left open."""

import os


def is_open(fd):
    try:
        os.fstat(fd)
    except OSError:
        return False
    return True


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = [fd for fd in range(3, 1024) if is_open(fd)][1:]
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
