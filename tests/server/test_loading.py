"""What is loaded at each start of a process of the service, and what is not."""

import subprocess
import sys

import pytest

HEAVY = {"numpy", "numba", "cv2", "scipy", "pyarrow", "pydantic", "seamark.sim.camera"}


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("seamark.server.app", "numpy pydantic"),
        ("seamark.server.programs.reader_process", ""),
    ],
)
def test_the_service_starts_without_the_simulator_and_an_upload_is_read_without_libraries(
    module: str, heavy: str
) -> None:
    program = f"import sys, {module}; print(*sorted({HEAVY} & set(sys.modules)))"

    said = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    ).stdout

    assert said.strip() == heavy
