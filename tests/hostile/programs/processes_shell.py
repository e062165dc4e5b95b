"""Starts a shell."""

import subprocess


class Controller:
    def __init__(self, config):
        subprocess.run(["/bin/sh", "-c", "id"], check=True)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
