"""`./run fuzz [SECONDS]`: coverage-guided fuzzing of both sides of the protocol with atheris.

Each side gets half of the time. A finding stops the session with the bytes that made it, which
belong into test_fuzz.py as an example. What was interesting is kept in .run/fuzz for the next time.
"""

import subprocess
import sys
from pathlib import Path

SECONDS = 60
KEPT = Path(".run/fuzz")
MOST_PACKETS = 12
MOST_BYTES = 4096


def packets_of(data: bytes) -> list[bytes]:
    """Cut bytes into packets: length, shape, content.

    An even shape makes a frame with a header that is right but for its kind: bytes alone would
    hardly ever get past the first look.
    """
    from seamark.sandbox.protocol import messages

    packets: list[bytes] = []
    while len(data) >= 4 and len(packets) < MOST_PACKETS:
        size, shape, kind = int.from_bytes(data[:2], "little") % MOST_BYTES, data[2], data[3:4]
        body, data = data[4 : 4 + size], data[4 + size :]
        packets.append(body if shape % 2 else messages.frame(kind, shape >> 1, body))
    return packets


def trusted_once(data: bytes) -> None:
    """Fuzz the trusted side once."""
    from tests.fuzz import sides

    sides.trusted(packets_of(data), data[:64])


def runner_once(data: bytes) -> None:
    """Fuzz the runner's own reading of frames and answers, in this process: no fork, no exit."""
    from seamark.sandbox.languages.python_inside import images, values

    values.Observation._fields.clear()
    values.observe_by({"observation": [["t", 0], ["error", 3], ["on", 0]], "booleans": ["on"]})
    seen = values.Observation(data)
    for name in seen:
        try:
            seen[name]
        except (ValueError, OverflowError) as error:  # too short: said by the runner as an error
            str(error)
        except images.struct.error:
            return
    for convert in (values.as_command, images.as_track, images.as_detections):
        for answer in (data, list(data), [[*data[:2]]] * 4, [("a", [[*data[:2]]] * 4, 0.5)]):
            try:
                convert(answer)
            except values.AnswerInvalid:
                continue


def fuzz(side: str, seconds: int) -> None:
    """Fuzz one side; never returns."""
    import atheris

    with atheris.instrument_imports(include=["sandbox"]):
        pass
    folder = KEPT / side
    folder.mkdir(parents=True, exist_ok=True)
    options = [f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048", "-verbosity=1"]
    once = trusted_once if side == "trusted" else runner_once
    atheris.Setup([sys.argv[0], *options, f"-artifact_prefix={folder}/", str(folder)], once)
    atheris.Fuzz()


def main(arguments: list[str]) -> int:
    """Fuzz both sides, each in a process of its own."""
    if arguments[:1] in (["trusted"], ["runner"]):
        fuzz(arguments[0], int(arguments[1]))
    seconds = int(arguments[0]) if arguments else SECONDS
    for side in ("trusted", "runner"):
        command = [sys.executable, "-m", "tests.fuzz.session", side, str(max(seconds // 2, 1))]
        if code := subprocess.call(command):
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
