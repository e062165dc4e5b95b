"""Switches core dumps on."""

import resource


class Controller:
    def __init__(self, config):
        got = None
        try:
            resource.setrlimit(resource.RLIMIT_CORE, (1 << 30, 1 << 30))
            got = "core"
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
