"""Works between its answers."""

import threading
import time


def spin():
    while True:
        pass


class Controller:
    def __init__(self, config):
        self.until_s = 0.0
        threading.Thread(target=spin, daemon=True).start()

    def step(self, observation):
        self.until_s += 0.1
        while time.process_time() < self.until_s:  # of both threads
            time.sleep(0.01)
        return [0.0, 0.0, 0.0, 0.0]
