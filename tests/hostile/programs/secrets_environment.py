"""Looks for variables of the worker."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = sorted(
                set(os.environ)
                - {
                    "PATH",
                    "HOME",
                    "LANG",
                    "PYTHONHASHSEED",
                    "PYTHONPATH",
                    "OPENBLAS_NUM_THREADS",
                    "OPENBLAS_CORETYPE",
                    "OMP_NUM_THREADS",
                    "OPENCV_FOR_THREADS_NUM",
                    "ORT_DISABLE_TELEMETRY",
                    "MALLOC_ARENA_MAX",
                    "PWD",
                    "LC_CTYPE",
                }
            )
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]
