"""Calls a program in Python without any guard, and says what it is given.

Arguments: the program's file, its configuration as JSON, its role.
"""

import itertools
import json
import math
import os
import sys
import time
from types import ModuleType, SimpleNamespace

import seamark  # noqa: F401  (attacks look for it)

REPORT, STEPS, SLOW_S = 301, 20, 0.7
MOST = 64  # detections of an answer, and bytes of a label
OBSERVED = [0.1, 0.2, 0.3]
PID = os.getpid()


def report(text: str) -> None:
    os.write(REPORT, f"\nCALLER: {text}\n".encode("utf-8", "replace"))


def is_command(answer: object) -> bool:
    return (
        type(answer) is list
        and len(answer) == 4
        and all(type(number) is float and abs(number) <= 1e6 for number in answer)
    )


def are_corners(answer: object) -> bool:
    try:
        return all(math.isfinite(n) for point in answer for n in point) and len(answer) == 4
    except TypeError:
        return False


def looked_at(took_s: float, answer: object, good: bool) -> None:
    """Say what is wrong after an answer."""
    if took_s > SLOW_S:
        report(f"an answer took {took_s:.1f} s")
    if not good:
        report(f"took {type(answer).__name__} {repr(answer)[:100]}")
    if os.getpid() != PID:
        report("a second process answers")
    for number, name in ((2, "log"), (3, "connection")):
        try:
            os.fstat(number)
        except OSError:
            report(f"its {name} is closed")


def control(program: object) -> None:
    truth = {"hidden_seed": [4711]}
    if hasattr(program, "reset"):
        program.reset({"index": 0})
    for step in range(STEPS):
        observation = SimpleNamespace(
            t=step / 20, error=array(OBSERVED), depth=5.0, target_visible=True, truth=truth
        )
        begin = time.monotonic()
        answer = program.step(observation)
        looked_at(time.monotonic() - begin, answer, is_command(answer))
        if observation.t != step / 20 or list(observation.error) != OBSERVED:
            report(f"the observation is {observation.t} {observation.error}")
        if not is_command(answer):
            [float(number) for number in answer]


def array(numbers: list[float]) -> object:
    """Return an array for a program that uses NumPy: to load it takes longer than all the rest."""
    if "numpy" not in sys.modules:
        return list(numbers)
    import numpy as np

    return np.array(numbers)


def track(program: object) -> None:
    import numpy as np

    image = np.frombuffer(shared_memory(), np.uint8, 240 * 320).reshape(240, 320)
    program.start(image, np.array([[10.0, 20.0], [30.0, 20.0], [30.0, 40.0], [10.0, 40.0]]))
    for value in range(6):
        image[:] = value
        begin = time.monotonic()
        answer = program.update(image)
        looked_at(time.monotonic() - begin, answer, are_corners(answer))
        if (image != value).any():
            report("the image changed")


def find(program: object) -> None:
    import numpy as np

    image = np.frombuffer(shared_memory(), np.uint8, 240 * 320).reshape(240, 320)
    for value in range(6):
        image[:] = value
        begin = time.monotonic()
        answer = program.detect(image)
        looked_at(time.monotonic() - begin, answer, good=True)
        if type(answer) is not list:
            report(f"took {type(answer).__name__}")
        first = list(itertools.islice(answer, MOST + 1))
        if len(first) > MOST:
            report(f"took more than {MOST} detections")
        for one in first[:MOST]:
            look_at_detection(*one)


def look_at_detection(label: str, corners: object, confidence: float) -> None:
    """Say what is wrong with a detection."""
    size = len(str.encode(label, errors="surrogatepass"))
    if not 0 < size <= MOST or not str.isprintable(label):
        report(f"took a label of {size} bytes: {str.__repr__(label)[:40]}")
    if not are_corners(corners):
        report(f"took the corners {str(corners)[:100]}")
    if not 0.0 <= confidence <= 1.0:
        report(f"took the confidence {confidence}")


def shared_memory():
    import mmap

    descriptor = os.memfd_create("images")
    os.set_inheritable(descriptor, True)
    os.ftruncate(descriptor, 1 << 20)
    return mmap.mmap(descriptor, 1 << 20)


def main() -> None:
    path, config, role = sys.argv[1:]
    report("calls")
    module = ModuleType("controller")
    module.__file__ = path
    sys.modules["controller"] = module
    with open(path, "rb") as file:
        exec(compile(file.read(), path, "exec"), module.__dict__)  # noqa: S102
    program_class = getattr(module, role.capitalize())
    {"controller": control, "tracker": track, "detector": find}[role](
        program_class(json.loads(config))
    )
    report("finished")


main()
