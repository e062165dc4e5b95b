"""Works between its answers."""

import threading
import time


def spin():
    while True:
        pass


class Controller:
    def __init__(self, config):
        threading.Thread(target=spin, daemon=True).start()

    def step(self, observation):
        time.sleep(0.2)
        return [0.0, 0.0, 0.0, 0.0]
