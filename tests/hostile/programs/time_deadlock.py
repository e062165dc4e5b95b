"""Waits for itself."""

import threading


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        lock = threading.Lock()
        with lock, lock:
            pass
        return [0.0, 0.0, 0.0, 0.0]
