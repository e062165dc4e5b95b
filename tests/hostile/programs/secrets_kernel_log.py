"""Reads the kernel's log."""

import ctypes


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = ctypes.CDLL(None).klogctl(3, ctypes.create_string_buffer(4096), 4096) > 0
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
