"""The program at the other end of a bridge, as the simulation calls it."""

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.lock_step import LockStep
from seamark.bridge.rosbridge.navigation import DeadReckoning
from seamark.bridge.rosbridge.protocol import NS
from seamark.bridge.rosbridge.server import Server, TcpAddress, serve_until
from seamark.bridge.rosbridge.topics import Moment, Stamp
from seamark.sim.camera.optics import Optics
from seamark.sim.control.observation import Images, Observation, arm_size
from seamark.sim.engine.program import Command
from seamark.sim.vehicles.linkage import Linkage


class RosProgram:
    """A `seamark.sim.engine.program.Program` that looks through the camera, behind a bridge."""

    def __init__(self, bridge: "Bridge", optics: Optics, arm: Linkage | None = None) -> None:
        self._bridge = bridge
        self._optics = optics
        self._motors = () if arm is None else arm.motors()
        self._arm = None if arm is None else arm_size(arm)
        self._navigation = DeadReckoning()
        self._level: Mapping[str, float | int] = {}
        self._begins = False
        self._camera: Callable[[], NDArray[np.uint8]] = lambda: np.zeros((0, 0, 3), np.uint8)
        self._images: Images | None = None
        self._new_images = False

    def look_through(self, camera: Callable[[], NDArray[np.uint8]]) -> None:
        """Take the function that renders an image."""
        self._camera = camera

    def show(self, images: Images) -> None:
        """Take the newest images."""
        self._images, self._new_images = images, True

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Announce a level with its first observation."""
        self._level, self._begins = dict(level), True
        self._navigation.reset()

    def step(self, values: NDArray[np.float64]) -> Command:
        """Publish an observation and return the reference that answers it; raises ProgramEnded."""
        seen = Observation(values, self._arm, self._images)
        self._navigation.step(seen)
        now = Moment(
            step=round(seen.t / seen.dt),
            stamp=Stamp(round(seen.t * NS)),
            level=self._level,
            begins=self._begins,
            seen=seen,
            navigation=self._navigation,
            optics=self._optics,
            motors=self._motors,
            image=cache(self._camera),
            new_images=self._new_images,
        )
        self._begins = self._new_images = False
        return self._bridge.wait_for(self._bridge.server.exchange(now))


class Bridge:
    """A server with its event loop in a thread of its own."""

    def __init__(self, server: Server, loop: asyncio.AbstractEventLoop, port: int) -> None:
        self.server, self.port = server, port
        self._loop = loop

    def wait_for(self, work: Coroutine[Any, Any, Command]) -> Command:
        """Return what a coroutine returns in the event loop."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    def publish_result(self, text: str) -> None:
        """Publish how the run ended, before the bridge closes."""
        asyncio.run_coroutine_threadsafe(self.server.publish_result(text), self._loop).result()


@contextmanager
def opened(
    lock_step: LockStep,
    address: TcpAddress | Path,
    *,
    say: Callable[[str], None],
    axes: Axes = Axes.NED,
) -> Iterator[Bridge]:
    """Provide a bridge that listens; `say` gets sentences about its clients.

    Raises
    ------
    OSError
        The address cannot be used.
    """
    server, end = Server(lock_step, say, axes), asyncio.Event()
    listening: Future[tuple[asyncio.AbstractEventLoop, int]] = Future()

    async def serve() -> None:
        loop = asyncio.get_running_loop()
        await serve_until(
            *(end, server, address), listening=lambda port: listening.set_result((loop, port))
        )

    def run() -> None:
        try:
            asyncio.run(serve())
        except OSError as error:
            listening.set_exception(error)

    thread = threading.Thread(target=run, name="rosbridge", daemon=True)
    thread.start()
    loop, server_loop = listening.result()
    try:
        yield Bridge(server, loop, server_loop)
    finally:
        loop.call_soon_threadsafe(end.set)
        thread.join()
