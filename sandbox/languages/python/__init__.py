"""Python: the interpreter of this service, with its NumPy, SciPy, OpenCV and ONNX Runtime."""

from pathlib import Path

from seamark.sandbox.languages.language import (
    ALL_ROLES,
    DETECTOR,
    TRACKER,
    Calls,
    Declarations,
    Language,
)
from seamark.sandbox.languages.sample import Sample, sample
from seamark.sandbox.runtime import Runtime

HERE = Path(__file__).parent


def runtime() -> Runtime:
    """Return command, environment and files of the interpreter."""
    from seamark.sandbox.languages.python.host import python_runtime  # noqa: PLC0415  (lazily)

    return python_runtime()


PYTHON = Language(
    name="python",
    label="Python",
    suffixes=(".py",),
    runtime=runtime,
    calls=Calls("The program (import and __init__)", "reset(level)", "step(observation)"),
    self_test=sample(HERE / "self_test.py"),
    starters=(
        sample(HERE / "starter/controller.py"),
        Sample(files={"controller.py": HERE / "starter/arm_controller.py"}, moves_arm=True),
        sample(HERE / "starter/tracker.py", role=TRACKER),
        sample(HERE / "starter/detector.py", role=DETECTOR),
    ),
    conformance=(
        sample(HERE / "starter/controller.py"),
        sample(HERE / "conformance/tracker.py", role=TRACKER),
        sample(HERE / "conformance/detector.py", role=DETECTOR),
    ),
    archive_mains=("main.py", "controller.py", "tracker.py", "detector.py"),
    roles=ALL_ROLES,
    syntax="python",
    declarations=Declarations.LITERAL,
    states_encoding=True,
    in_the_box=(
        "The standard library is complete. `import cv2` gives OpenCV with its contrib modules; its "
        "functions that show windows or open cameras fail. ONNX Runtime runs a trained network: "
        "put `main.py` and the exported `.onnx` file into one archive and open it by its name, "
        '`onnxruntime.InferenceSession("policy.onnx")`. All of these libraries compute with one '
        "thread."
    ),
)
