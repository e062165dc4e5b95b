"""Imports ONNX Runtime without its complaints: it looks for /proc/cpuinfo, which no box has.

It needs nothing from there, but its five lines would be the first ones in every log.
"""

import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import ExtensionFileLoader, ModuleSpec, PathFinder
from types import ModuleType

NATIVE_MODULE = "onnxruntime.capi.onnxruntime_pybind11_state"
STREAMS = (1, 2)  # standard output and standard error


class QuietLoader(ExtensionFileLoader):
    """Loads a native module; what it prints meanwhile is dropped."""

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Load the library and create its module."""
        with dropped_output():
            return super().create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Initialize the module."""
        with dropped_output():
            super().exec_module(module)


class Finder:
    """Finds the native module of ONNX Runtime, and no other."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where the module is, with a loader that drops its output."""
        if name != NATIVE_MODULE:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and spec.origin is not None:
            spec.loader = QuietLoader(name, spec.origin)
        return spec


@contextlib.contextmanager
def dropped_output() -> Iterator[None]:
    """Drop what native code writes to the standard streams."""
    kept = [os.dup(stream) for stream in STREAMS]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream in STREAMS:
            os.dup2(nowhere, stream)
        yield
    finally:
        for stream, copy in zip(STREAMS, kept, strict=True):
            os.dup2(copy, stream)
        for descriptor in (nowhere, *kept):
            os.close(descriptor)


def install() -> None:
    """Have imports ask the finder first."""
    sys.meta_path.insert(0, Finder)
