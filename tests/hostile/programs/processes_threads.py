"""Starts threads without end."""

import threading
import time


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        while True:
            threading.Thread(target=time.sleep, args=(60,), daemon=True).start()
        return [0.0, 0.0, 0.0, 0.0]
