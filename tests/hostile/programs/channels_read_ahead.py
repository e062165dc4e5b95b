"""Loads a library into the page cache without reading it."""

import ctypes
import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            libc = ctypes.CDLL(None, use_errno=True)
            library = os.open("/usr/lib/x86_64-linux-gnu/libm.so.6", os.O_RDONLY)
            got = libc.syscall(187, library, ctypes.c_long(0), ctypes.c_size_t(4096)) == 0
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
