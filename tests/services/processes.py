"""Ending processes that a test has started."""

import subprocess


def end(process: "subprocess.Popen[bytes]", grace_s: float) -> None:
    """Stop a process; kill it if it has not ended after a while [s]."""
    process.terminate()
    try:
        process.wait(grace_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
