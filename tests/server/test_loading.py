"""What is loaded at each start of a process of the service, and what is not."""

import subprocess
import sys

import pytest

HEAVY = {
    *("numpy", "numba", "cv2", "scipy", "pyarrow", "pydantic", "rich", "authlib", "requests"),
    "seamark.sim.camera",
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("seamark.server.app", "numpy pydantic"),
        ("seamark.server.programs.reader_process", ""),
        ("seamark.worker.service.nursery", ""),
        ("seamark.worker.service.check_loop", "numpy pydantic"),
        ("seamark.worker.service.maintenance", "numpy pydantic"),
    ],
)
def test_a_process_of_the_service_loads_no_library_that_it_does_without(
    module: str, heavy: str
) -> None:
    program = f"import sys, {module}; print(*sorted({HEAVY} & set(sys.modules)))"

    said = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    ).stdout

    assert said.strip() == heavy
