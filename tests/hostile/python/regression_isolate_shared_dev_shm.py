"""Looks for what another box left in shared memory, and leaves something (isolate)."""

import os
from multiprocessing import resource_tracker


class Controller:
    def __init__(self, config):
        for folder in ("/dev/shm", "/tmp", "/dev/mqueue", "/run/shm"):
            found = os.listdir(folder) if os.path.isdir(folder) else []
            if found:
                print("GOT", folder, found)
            try:
                with open(f"{folder}/from-another-box", "w") as file:
                    file.write("do you read me")
            except OSError as error:
                print("held:", error)

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
