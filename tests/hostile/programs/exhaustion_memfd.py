"""Memory that is in no address space."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = os.memfd_create("heap")
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
