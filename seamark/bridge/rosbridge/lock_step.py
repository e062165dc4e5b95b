"""Lock step: the simulation publishes an observation and waits for the reference that answers it.

A program publishes one reference for each observation. Nothing else decides when the simulation
goes on, so the same program gives the same result however fast the machine or the network is.
"""

import asyncio
from collections.abc import Iterable

from seamark.bridge import failures
from seamark.bridge.rosbridge.client import Client
from seamark.bridge.rosbridge.protocol import Publish, Refused, read_reference
from seamark.bridge.rosbridge.topics import NS, Moment
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim.engine.program import Command

SECOND = (
    "A second velocity reference came for the observation at t = {t:g} s. Publish exactly one for "
    "each observation, or a TwistStamped that repeats the time stamp of its observation. A program "
    "that publishes by its own clock needs --real-time."
)


class LockStep:
    """Who controls the vehicle, and the answers of that client. Belongs to the event loop."""

    def __init__(self, *, answer_within_s: float, real_time: bool) -> None:
        """Set up.

        Parameters
        ----------
        answer_within_s : float [s]
            Wall time for an answer, once the program has answered for the first time.
        real_time
            Go on by the wall clock with the last reference, instead of waiting for answers.
        """
        self._answer_within_s = answer_within_s
        self._real_time = real_time
        self._controller: Client | None = None
        self._begun = False
        self._ended: ProgramEnded | None = None
        self._answer: asyncio.Future[Command] | None = None
        self._latest: Command = (0.0, 0.0, 0.0, 0.0)
        self._next_tick_s = 0.0  # by the clock of the event loop
        self._last_refusal = ""
        self._now: Moment | None = None

    @property
    def waiting(self) -> Moment | None:
        """The observation that waits for its answer."""
        answered = self._answer is None or self._answer.done()
        return None if answered else self._now

    def become_controller(self, client: Client, topic: str) -> None:
        """Make a client the one that controls the vehicle; raises Refused if there is another."""
        if self._controller is None:
            self._controller = client
        if self._controller is not client:
            raise Refused(f"{topic}: {self._controller.address} controls the vehicle already.")

    def release(self, client: Client) -> None:
        """Let another client control the vehicle; a run that has begun ends."""
        if self._controller is not client:
            return
        self._controller = None
        if self._begun:
            when = "" if self._now is None else f" at t = {self._now.stamp.ns / NS:g} s"
            self._end(failures.left(f"The program disconnected{when}, before the run was over."))

    def refused(self, client: Client, text: str) -> None:
        """Remember what was refused, for the sentence with which a run ends."""
        if client is self._controller:
            self._last_refusal = text

    def take(self, client: Client, publication: Publish) -> None:
        """Take a reference of a client.

        Raises
        ------
        Refused
            It is not one, it is of another client, or it answers another observation.
        """
        self.become_controller(client, publication.topic)
        command, stamp_ns = read_reference(publication)
        self._latest = command
        now = self.waiting
        if now is None or self._answer is None:
            self._take_surplus(publication, stamped=stamp_ns is not None)
        elif stamp_ns not in (None, now.stamp.ns):
            raise Refused(
                f"{publication.topic}: the stamp {(stamp_ns or 0) / NS:g} s is not that of the "
                f"observation, {now.stamp.ns / NS:g} s.",
                reply_to=publication.id,
            )
        else:
            self._answer.set_result(command)

    def _take_surplus(self, publication: Publish, *, stamped: bool) -> None:
        """Take a reference while none is awaited."""
        if self._real_time:
            return
        if stamped or not self._begun or self._now is None:
            text = f"{publication.topic}: no observation waits for this reference."
            raise Refused(text, reply_to=publication.id)
        self._end(failures.wrong_answer(SECOND.format(t=self._now.stamp.ns / NS)))

    def _end(self, reason: ProgramEnded) -> None:
        self._ended = self._ended or reason
        if self._answer is not None and not self._answer.done() and not self._real_time:
            self._answer.set_exception(reason)

    async def exchange(self, now: Moment, clients: Iterable[Client]) -> Command:
        """Publish an observation and return the reference that answers it; raises ProgramEnded."""
        if self._ended is not None:
            raise self._ended
        self._now, self._answer = now, asyncio.get_running_loop().create_future()
        await asyncio.gather(*(client.publish(now) for client in tuple(clients)))
        if self._real_time and self._begun:
            await self._next_tick(now)
            self._answer.cancel()
            return self._latest
        command = await self._answered(self._answer, now)
        self._begun = True
        self._next_tick_s = asyncio.get_running_loop().time() + now.seen.dt
        return command

    async def _answered(self, answer: asyncio.Future[Command], now: Moment) -> Command:
        limit_s = self._answer_within_s if self._begun else None
        try:
            async with asyncio.timeout(limit_s):
                return await answer
        except TimeoutError:
            refusal = f" Refused: {self._last_refusal}" if self._last_refusal else ""
            raise failures.no_answer(
                f"No velocity reference came within {limit_s:g} s after the observation at "
                f"t = {now.stamp.ns / NS:g} s.{refusal}"
            ) from None

    async def _next_tick(self, now: Moment) -> None:
        clock = asyncio.get_running_loop().time
        await asyncio.sleep(max(self._next_tick_s - clock(), 0.0))
        self._next_tick_s = max(self._next_tick_s, clock() - now.seen.dt) + now.seen.dt
        if self._ended is not None:
            raise self._ended
