"""Processes of tests that begin as forks of one that has loaded all modules of tests.

pytest-xdist starts Python for each, which spends five seconds of CPU time on the same imports.
"""

import gc
import os
import re
import signal
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import pytest
from _pytest.capture import CaptureManager
from _pytest.outcomes import OutcomeException
from _pytest.pathlib import ImportMode, import_path, module_name_from_path
from execnet import XSpec, gateway_io

from tests.services import compiled_once, prepared

# Libraries whose threads start as they are loaded: a fork would be without them.
_WITH_THREADS = re.compile(r"^(import|from) (onnxruntime|pandas|polars|pyarrow)\b", re.MULTILINE)
_FAILED = 1


class ForkedProcess:
    """What execnet asks of a `Popen` whose process it talks to."""

    def __init__(self, before: "Iterable[ForkedProcess]") -> None:
        its_stdin, to_stdin = os.pipe()
        from_stdout, its_stdout = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            # Or a process would not see that the first one, from which it reads, has ended.
            for end in (to_stdin, from_stdout, *(end for other in before for end in other.ends())):
                os.close(end)
            _serve(its_stdin, its_stdout)
        os.close(its_stdin)
        os.close(its_stdout)
        self.stdin, self.stdout = os.fdopen(to_stdin, "wb"), os.fdopen(from_stdout, "rb")

    def ends(self) -> tuple[int, int]:
        """Return the descriptors of its pipes that this process has."""
        return self.stdin.fileno(), self.stdout.fileno()

    def wait(self) -> int:
        """Wait until it has ended."""
        return os.waitstatus_to_exitcode(os.waitpid(self._pid, 0)[1])

    def kill(self) -> None:
        """Kill it, which has not been waited for."""
        os.kill(self._pid, signal.SIGKILL)


class _Connection(gateway_io.Popen2IOMaster):
    def __init__(self, process: ForkedProcess, execmodel: Any) -> None:
        self.popen = process
        super(gateway_io.Popen2IOMaster, self).__init__(process.stdin, process.stdout, execmodel)


def start(config: pytest.Config, specs: list[XSpec]) -> None:
    """Fork a process for each that pytest-xdist is about to start.

    It starts them itself if there are threads, which would be missing in a fork, and in place of
    one that has crashed.
    """
    if not all(spec.popen for spec in specs):
        return
    _load(config)
    if "seamark.server.app" in sys.modules:
        compiled_once.prepare()
    if (threads := len(os.listdir("/proc/self/task"))) > 1:
        reporter: pytest.TerminalReporter = config.pluginmanager.getplugin("terminalreporter")
        reporter.write_line(f"No forks: loading the tests started {threads - 1} threads.")
        return
    prepared.share()
    sys.stdout.flush()
    sys.stderr.flush()
    gc.freeze()  # forks share what is loaded as long as nobody touches it
    started = list[ForkedProcess]()
    for _ in specs:
        started.append(ForkedProcess(started))
    _connect(iter(started))


def _load(config: pytest.Config) -> None:
    capture: CaptureManager | None = config.pluginmanager.getplugin("capturemanager")
    assert capture is not None
    capture.resume_global_capture()  # libraries print
    for path in _modules(config):
        if _WITH_THREADS.search(path.read_text()):
            continue
        try:
            import_path(
                path,
                mode=ImportMode.importlib,
                root=config.rootpath,
                consider_namespace_packages=False,
            )
        except (Exception, OutcomeException):
            # Half a module stays. Without it, each process fails in the same way and reports it.
            sys.modules.pop(module_name_from_path(path, config.rootpath), None)
    capture.suspend_global_capture()
    capture.read_global_capture()


def _modules(config: pytest.Config) -> Iterator[Path]:
    for argument in config.args:
        path = Path(config.invocation_params.dir, argument.partition("::")[0])
        yield from sorted(path.rglob("test_*.py")) if path.is_dir() else (path,)


def _connect(processes: Iterator[ForkedProcess]) -> None:
    of_execnet = gateway_io.create_io

    def create_io(spec: XSpec, execmodel: Any) -> gateway_io.Popen2IOMaster:
        process = next(processes, None)
        return _Connection(process, execmodel) if process else of_execnet(spec, execmodel)

    gateway_io.create_io = create_io


def _serve(stdin: int, stdout: int) -> NoReturn:
    """Do what the process does that execnet starts: `python -c` with its first line."""
    status = _FAILED
    try:
        for place, end in enumerate((stdin, stdout)):
            os.dup2(end, place)
            os.close(end)
        # execnet replaces them, and what they write to stays open.
        sys.stdin, sys.stdout = open(0, closefd=False), open(1, "w", closefd=False)
        sys.argv, sys.modules["__main__"] = ["-c"], ModuleType("__main__")
        exec(eval(sys.stdin.readline()), vars(sys.modules["__main__"]))  # noqa: S102, S307
        status = 0
    finally:
        os._exit(status)  # not back into the tests of the process that was forked
