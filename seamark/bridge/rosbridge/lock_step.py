"""Lock step: the simulation publishes an observation and waits for the reference that answers it.

A program publishes one reference for each observation. Nothing else decides when the simulation
goes on, so the same program gives the same result however fast the machine or the network is.
"""

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass

from seamark.bridge import failures
from seamark.bridge.rosbridge.client import Client
from seamark.bridge.rosbridge.protocol import (
    NS,
    Publish,
    Refused,
    read_joint_speeds,
    read_reference,
)
from seamark.bridge.rosbridge.topics import Moment
from seamark.sandbox.outcome import ProgramEnded
from seamark.sim.engine.program import Command

SECOND = (
    "A second velocity reference came for the observation at t = {t:g} s. Publish exactly one for "
    "each observation, or a TwistStamped that repeats the time stamp of its observation. A program "
    "that publishes by its own clock needs --real-time."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """How long the simulation waits, and for whom. Times are wall times [s]; None: no limit."""

    answer_s: float  # for an answer, once the program has answered for the first time
    first_answer_s: float | None = None
    whole_s: float | None = None  # from the first observation to the end of the run
    real_time: bool = False  # go on by the wall clock with the last reference, do not wait
    one_client: bool = False  # the run ends with its client, whether it has begun or not


class LockStep:
    """Who controls the vehicle, and the answers of that client. Belongs to the event loop."""

    def __init__(self, rules: Rules, *, joints: int = 0) -> None:
        """Set up; `joints` is how many motors the vehicle's arm has, which rest at first."""
        self._rules = rules
        self._joint_speeds: Command = (0.0,) * joints
        self._controller: Client | None = None
        self._begun = False
        self._ended: ProgramEnded | None = None
        self._answer: asyncio.Future[Command] | None = None
        self._latest: Command = (0.0, 0.0, 0.0, 0.0)
        # By the clock of the event loop.
        self._next_tick_s = 0.0
        self._ends_at_s: float | None = None
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
            self._end_without_client()

    def disconnected(self, client: Client) -> None:
        """Take leave of a client that has disconnected."""
        self.release(client)
        if self._rules.one_client:
            self._end_without_client()

    def _end_without_client(self) -> None:
        when = "" if self._now is None else f" at t = {self._now.stamp.ns / NS:g} s"
        self._end(
            failures.disconnected(f"The program disconnected{when}, before the run was over.")
        )

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
        command, stamp_ns = read_reference(publication, client.axes)
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

    def take_joint_speeds(self, client: Client, publication: Publish) -> None:
        """Take the speeds of an arm's joints, which go with this reference and all later ones.

        Raises
        ------
        Refused
            They are none, or of another client than the one that controls the vehicle.
        """
        self.become_controller(client, publication.topic)
        self._joint_speeds = read_joint_speeds(publication, len(self._joint_speeds))

    def _take_surplus(self, publication: Publish, *, stamped: bool) -> None:
        """Take a reference while none is awaited."""
        if self._rules.real_time:
            return
        if stamped or not self._begun or self._now is None:
            text = f"{publication.topic}: no observation waits for this reference."
            raise Refused(text, reply_to=publication.id)
        self._end(failures.wrong_answer(SECOND.format(t=self._now.stamp.ns / NS)))

    def _end(self, reason: ProgramEnded) -> None:
        self._ended = self._ended or reason
        if self._answer is not None and not self._answer.done() and not self._rules.real_time:
            self._answer.set_exception(reason)

    async def exchange(self, now: Moment, clients: Iterable[Client]) -> Command:
        """Publish an observation and return the reference that answers it; raises ProgramEnded."""
        if self._ended is not None:
            raise self._ended
        self._now, self._answer = now, asyncio.get_running_loop().create_future()
        await asyncio.gather(*(client.publish(now) for client in tuple(clients)))
        if self._rules.real_time and self._begun:
            await self._next_tick(now)
            self._answer.cancel()
            return self._latest + self._joint_speeds
        command = await self._answered(self._answer, now)
        self._begun = True
        self._next_tick_s = asyncio.get_running_loop().time() + now.seen.dt
        return command + self._joint_speeds

    async def _answered(self, answer: asyncio.Future[Command], now: Moment) -> Command:
        limit_s = self._rules.answer_s if self._begun else self._rules.first_answer_s
        left_s = self._left_s()
        limits = [each for each in (limit_s, left_s) if each is not None]
        try:
            async with asyncio.timeout(min(limits, default=None)):
                return await answer
        except TimeoutError:
            if left_s is not None and (limit_s is None or left_s <= limit_s):
                raise failures.no_answer(
                    f"The run took {self._rules.whole_s:g} s, the most that a connection may last. "
                    f"It had come to t = {now.stamp.ns / NS:g} s."
                ) from None
            refusal = f" Refused: {self._last_refusal}" if self._last_refusal else ""
            raise failures.no_answer(
                f"No velocity reference came within {limit_s:g} s after the observation at "
                f"t = {now.stamp.ns / NS:g} s.{refusal}"
            ) from None

    def _left_s(self) -> float | None:
        """Return the time until the run must be over; it begins with the first call."""
        if self._rules.whole_s is None:
            return None
        time_s = asyncio.get_running_loop().time()
        if self._ends_at_s is None:
            self._ends_at_s = time_s + self._rules.whole_s
        return max(self._ends_at_s - time_s, 0.0)

    async def _next_tick(self, now: Moment) -> None:
        clock = asyncio.get_running_loop().time
        await asyncio.sleep(max(self._next_tick_s - clock(), 0.0))
        self._next_tick_s = max(self._next_tick_s, clock() - now.seen.dt) + now.seen.dt
        if self._ended is not None:
            raise self._ended
