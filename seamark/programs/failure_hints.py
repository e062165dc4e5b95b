"""What to do about failures that have one usual cause, recognised by the sandbox's sentence."""

import re
from dataclasses import dataclass

from seamark.programs.role_names import without_role
from seamark.sandbox.languages import LANGUAGES

IN_THE_BOX = "/docs/box"  # the page that lists what programs find
_ABSENT_MODULE = re.compile(r"ModuleNotFoundError: No module named '(\w+)")
_FRAMEWORKS = {"torch", "torchvision", "tensorflow", "keras", "jax", "flax", "tflite_runtime"}
_CLIENTS = {"requests", "aiohttp", "httpx", "urllib3", "websockets", "zmq", "rospy", "rclpy"}
_ISOLATED = (
    "A program runs in a sandbox: it has no network and sees no files except its own in /tmp. "
    "Put everything it needs into the program itself, or into an archive with it."
)


@dataclass(frozen=True, slots=True)
class Hint:
    """What to do, and a page of the documentation about it; both may be empty."""

    remedy: str = ""
    page: str = ""


_HINTS = (  # the first one whose pattern is in the sentence
    (
        re.compile(r"fatal error: .*: No such file or directory"),
        Hint("Put your own headers into an archive with the program.", IN_THE_BOX),
    ),
    (
        re.compile(
            r"gaierror|URLError|ConnectionError|Network is unreachable|[Cc]ouldn't resolve host"
        ),
        Hint(_ISOLATED, IN_THE_BOX),
    ),
    (re.compile(r"^(PermissionError|FileNotFoundError)"), Hint(_ISOLATED)),
    (
        re.compile("|".join(f"^{re.escape(one.calls.start)}" for one in LANGUAGES.values())),
        Hint(
            "The start has a limit of its own. Compute tables and train networks beforehand, and "
            "put the results into an archive with the program."
        ),
    ),
    (
        re.compile(r"^The program was ended by SIGSEGV"),
        Hint(
            "Look for an index out of bounds, a null pointer or infinite recursion. On "
            "your own machine, `gcc -g -fsanitize=address` says more."
        ),
    ),
)


def hint(sentence: str) -> Hint:
    """Return what to do about a failure; an empty hint if its sentence says nothing special."""
    sentence = without_role(sentence)
    if absent := _ABSENT_MODULE.match(sentence):
        return Hint(_absent_module(absent[1]), IN_THE_BOX)
    return next((advice for pattern, advice in _HINTS if pattern.search(sentence)), Hint())


def _absent_module(name: str) -> str:
    if name in _FRAMEWORKS:
        return (
            "Export the trained network to ONNX, put the .onnx file into an archive with main.py, "
            "and run it with onnxruntime."
        )
    if name in _CLIENTS:
        return _ISOLATED
    return (
        "Nothing can be installed in the sandbox. Modules in pure Python can be put into an "
        "archive beside main.py."
    )
