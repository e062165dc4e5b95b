"""Looks for any folder of the host."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = [
                n
                for n in (
                    "/etc",
                    "/home",
                    "/root",
                    "/var",
                    "/proc",
                    "/sys",
                    "/run",
                    "/opt",
                    "/usr/local",
                    "/usr/bin/sh",
                )
                if os.path.exists(n)
            ]
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
