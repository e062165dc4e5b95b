"""Cannot be asked to end."""

import signal


class Controller:
    def __init__(self, config):
        for name in set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP}:
            signal.signal(name, signal.SIG_IGN)

    def step(self, observation):
        while True:
            pass
        return [0.0, 0.0, 0.0, 0.0]
