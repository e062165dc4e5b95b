"""`./run fuzz [SECONDS]`: coverage-guided fuzzing of both ends of the protocol with atheris.

Each end gets half of the time. A finding stops the session with the bytes that caused it; add them
to test_fuzz.py as an example. The corpus is kept in .run/fuzz for the next time.
"""

import struct
import subprocess
import sys
from pathlib import Path

SECONDS = 60
CORPUS = Path(".run/fuzz")
MAX_PACKETS = 12
MAX_BYTES = 4096


def packets_of(data: bytes) -> list[bytes]:
    """Cut bytes into packets: length, shape, content.

    An even shape gives a message with a correct header except for its type: random bytes would
    hardly ever pass the first check.
    """
    from seamark.sandbox.protocol import messages

    packets: list[bytes] = []
    while len(data) >= 4 and len(packets) < MAX_PACKETS:
        size, shape, message_type = (
            int.from_bytes(data[:2], "little") % MAX_BYTES,
            data[2],
            data[3:4],
        )
        body, data = data[4 : 4 + size], data[4 + size :]
        packets.append(body if shape % 2 else messages.message(message_type, shape >> 1, body))
    return packets


def simulator_once(data: bytes) -> None:
    """Fuzz the simulator's end once."""
    from tests.fuzz import sides

    sides.simulator(packets_of(data), data[:64])


def runner_once(data: bytes) -> None:
    """Fuzz how the runner decodes messages and answers, in this process: no fork, no exit."""
    from seamark.sandbox.languages.python.inside import images, values

    values.Observation._fields.clear()
    values.set_layout({"observation": [["t", 0], ["error", 3], ["on", 0]], "booleans": ["on"]})
    seen = values.Observation(data)
    for name in seen:
        try:
            seen[name]
        except (ValueError, OverflowError) as error:  # too short: the runner reports an error
            str(error)
        except struct.error:
            return
    for convert in (values.as_command, images.as_track, images.as_detections):
        for answer in (data, list(data), [[*data[:2]]] * 4, [("a", [[*data[:2]]] * 4, 0.5)]):
            try:
                convert(answer)
            except values.AnswerInvalid:
                continue


def fuzz(side: str, seconds: int) -> None:
    """Fuzz one end; never returns."""
    import atheris

    with atheris.instrument_imports(include=["seamark.sandbox"]):
        pass
    folder = CORPUS / side
    folder.mkdir(parents=True, exist_ok=True)
    options = [f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048", "-verbosity=1"]
    once = simulator_once if side == "simulator" else runner_once
    atheris.Setup([sys.argv[0], *options, f"-artifact_prefix={folder}/", str(folder)], once)
    atheris.Fuzz()


def main(arguments: list[str]) -> int:
    """Fuzz both ends, each in its own process."""
    if arguments[:1] in (["simulator"], ["runner"]):
        fuzz(arguments[0], int(arguments[1]))
    seconds = int(arguments[0]) if arguments else SECONDS
    for side in ("simulator", "runner"):
        command = [sys.executable, "-m", "tests.fuzz.session", side, str(max(seconds // 2, 1))]
        if code := subprocess.call(command):
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
