"""One request and one answer through a box, compared with a pipe between two Python processes.

CPU time of both sides together, without their start. They share a core and alternate, so on an idle
machine it equals the wall time, and load does not change it. The pipe carries the same bytes to the
same arithmetic without any checks.
"""

import os
import struct
import subprocess
import sys
import time
from array import array

import numpy as np

from performance.sandbox import first_answers
from performance.tables import Row
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.limits import Limits
from seamark.sandbox.probing.probes import probe

FIELDS = 29  # float64 values of the real layout
STEPS = 20_000
SHOWN = 5_000
IMAGES = {"320x240": (240, 320), "640x480": (480, 640), "640x480 colour": (480, 640, 3)}
LAYOUT = {
    "observation": [["t", 0], ["error", 3], ["others", FIELDS - 4]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
PLAIN = """\
class Controller:
    def __init__(self, config):
        self.gain = 0.5

    def step(self, observation):
        t = self.gain * observation.t
        return [t, t, t, 0.0]
"""
TRACKER = """\
class Tracker:
    def __init__(self, config):
        self.corners = None

    def start(self, image, corners):
        self.corners = corners

    def update(self, image):
        return self.corners if image[0, 0] is not None else None
"""
ECHO = """\
import os, struct, time
pack, unpack = struct.Struct("<4d").pack, struct.Struct("<29d").unpack
{imported}
begin = time.process_time()
while True:
    data = os.read(0, 4096)
    if not data:
        break
    {answer}
os.write(1, struct.pack("<d", time.process_time() - begin))
"""
PLAIN_ECHO = ECHO.format(
    imported="", answer="t, *_ = unpack(data); os.write(1, pack(t, t, t, 0.0))"
)
NUMPY_ECHO = ECHO.format(
    imported="import numpy as np",
    answer="os.write(1, pack(*(0.5 * np.frombuffer(data, np.float64, 3, 8)), 0.0))",
)


def rows() -> list[Row]:
    """Measure and return the rows."""
    before = os.sched_getaffinity(0)
    isolation = probe().level
    core = max(before)
    os.sched_setaffinity(0, {core})
    try:
        return [
            Row(
                what=f"exchange with a program of {name}, isolation {isolation.name.lower()}",
                value=_boxed_us(program, isolation, core),
                unit="us CPU",
                baseline="pipe without checks",
                baseline_value=_pipe_us(echo),
            )
            for name, program, echo in (
                ("plain Python", PLAIN, PLAIN_ECHO),
                ("NumPy", PYTHON.self_test.text(), NUMPY_ECHO),
            )
        ] + [
            *_images(isolation, core),
            *first_answers.rows(isolation, core),
        ]
    finally:
        os.sched_setaffinity(0, before)


def _pipe_us(program: str) -> float:
    values = [0.5] * FIELDS
    pack, unpack = struct.Struct(f"<{FIELDS}d").pack, struct.Struct("<4d").unpack
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdin=-1, stdout=-1, bufsize=0) as echo:
        if echo.stdin is None or echo.stdout is None:
            raise RuntimeError("no pipes")
        out, back = echo.stdin.fileno(), echo.stdout.fileno()
        begin = time.process_time()
        for _ in range(STEPS):
            os.write(out, pack(*values))
            unpack(os.read(back, 4096))
        own_s = time.process_time() - begin
        echo.stdin.close()
        (echo_s,) = struct.unpack("<d", os.read(back, 8))
    return (own_s + float(echo_s)) / STEPS * 1e6


def _boxed_us(program: str, isolation: IsolationLevel, core: int) -> float:
    values = array("d", [0.5] * FIELDS)
    with Box(limits=Limits(), isolation=isolation, core=core) as box:
        box.load(program.encode(), "controller.py", {}, LAYOUT)
        box.reset({"index": 0})
        start_s = box.usage().cpu_s
        begin = time.process_time()
        for _ in range(STEPS):
            box.step(values)
        own_s = time.process_time() - begin
        return (own_s + box.usage().cpu_s - start_s) / STEPS * 1e6


def _images(isolation: IsolationLevel, core: int) -> list[Row]:
    """Return the rows of a tracker that reads one pixel, for images of three sizes."""
    return [
        Row(what=f"exchange with a tracker, image {name}", value=value, unit="us CPU")
        for name, shape in IMAGES.items()
        for value in (_shown_us(shape, isolation, core),)
    ]


def _shown_us(shape: tuple[int, ...], isolation: IsolationLevel, core: int) -> float:
    image = np.zeros(shape, np.uint8)
    with Box(limits=Limits(), isolation=isolation, core=core) as box:
        box.load(TRACKER.encode(), "tracker.py", {}, {"role": "tracker"})
        box.start(image, [(0.0, 0.0)] * 4)
        box.update(image)  # the first access to a memory page costs more
        box.update(image)
        begin = time.process_time()
        for _ in range(SHOWN):
            box.update(image)
        own_s = time.process_time() - begin
        return (own_s + box.finish().cpu_s) / SHOWN * 1e6
