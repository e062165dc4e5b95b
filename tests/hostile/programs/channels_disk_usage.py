"""Asks how full the disk of the host is."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            for name in ("/", "/tmp", "/usr/lib", "/dev"):
                try:
                    os.statvfs(name)
                    got = "the free space of a file system"
                except OSError as error:
                    print("held:", error)
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
