"""Leaves a link to a file of the host."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            os.symlink("/etc/shadow", "/tmp/output.txt")
            got = "link"
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
