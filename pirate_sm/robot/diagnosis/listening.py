"""Opens a port, asks its device for its topics, and listens to everything that it sends."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import inf, nan
from typing import Self

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import BuiltInFault, Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.robot.backends.serial.backend import ANSWER_WITHIN_S, SerialBackend
from pirate_sm.robot.backends.serial.link.conversation import Wanted, unanswered
from pirate_sm.robot.backends.serial.link.exchange import Exchange
from pirate_sm.robot.backends.serial.link.link_plan import STATE
from pirate_sm.robot.backends.serial.port import Port
from pirate_sm.robot.diagnosis.facts import ExpectedRobot, Facts, LinkFact, Records, TopicFact
from pirate_sm.robot.diagnosis.judgement import CHECKED_EVERY_S, judged
from pirate_sm.robot.rosserial import frames
from pirate_sm.robot.rosserial.frames import Decoder, encode
from pirate_sm.robot.rosserial.message_types import Malformed


def topic_facts(
    wanted: Sequence[Wanted],
    offered: Mapping[tuple[frames.Direction, str], frames.TopicInfo],
    counts: Mapping[int, int],
    elapsed_s: float,
) -> tuple[TopicFact, ...]:
    """Return the facts of each topic: the wanted ones, then those that only the device has.

    Args:
        wanted: The profile's topics.
        offered: The device's topics, by direction and name.
        counts: Number of frames of each topic, by its number.
        elapsed_s: Time over which they were counted, s.
    """
    found: list[TopicFact] = []
    others = dict(offered)
    for each in wanted:
        name = each.name.lstrip("/")
        info = others.pop((each.direction, name), None)
        ours = each.type, each.md5
        if info is None:
            found.append(TopicFact(name, each.direction, None, "", ours[0], "", ours[1], 0.0))
        else:
            found.append(_offered(info, *ours, counts, elapsed_s))
    return (*found, *(_offered(info, "", "", counts, elapsed_s) for info in others.values()))


def _offered(
    info: frames.TopicInfo, our_type: str, our_md5: str, counts: Mapping[int, int], elapsed_s: float
) -> TopicFact:
    rate = counts.get(info.number, 0) / elapsed_s
    its = info.name, info.direction, info.number, info.type
    return TopicFact(*its, our_type, info.md5, our_md5, rate)


_MORE_WITHIN_S = 1.5
"""A device that has introduced some of its topics has introduced the rest by then."""

_ASK_EVERY_S = 1.0
_LOOK_UP_S = 0.1
_SAMPLE_BYTES = 4096
_BEAT_EVERY_S = 0.05

Watch = Callable[["Listening"], None]


class Listening:
    """A connection to a robot that sends nothing of its own accord; a context manager.

    It moves nothing. But opening the port resets most controllers, which stops the motors that they
    were driving.

    Args:
        subject: The expected robot.
        port: The port.
        baud: Baud rate of the line.
        check: Is called many times a second; an exception from it ends the listening.

    Attributes:
        records: The boards' reports since counting began.
        results: The results of arrays, by id.
    """

    def __init__(
        self,
        subject: ExpectedRobot,
        port: Port,
        baud: int,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self.subject = subject
        self.port = port
        self._baud = baud
        self._check = check
        self._plan = subject.plan
        self.exchange = Exchange(self._plan, port.now(), port.epoch_s, baud)
        self.results: dict[int, SubmitResult] = {}
        self._sample = b""
        self._answer_s = nan
        self._late_s = 0.0
        self._connected = False
        self._decoder = Decoder()
        self._count_from(port.now())

    # --- connecting -------------------------------------------------------------------------

    def __enter__(self) -> Self:
        """Open the port, and wait until the device has introduced its topics.

        Raises:
            BackendError: There is no port, or no device on it that speaks rosserial.
        """
        self.port.open()
        try:
            self._connect()
        except BaseException:
            self.port.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Ask the device to stop publishing, and close the port."""
        stopped = self.exchange.stopped.confirmed
        with suppress(BackendError):
            if stopped:
                self.port.write(self.exchange.conversation.farewell())
        self.port.close(stopped)

    def _connect(self) -> None:
        opened_s = self.port.now()
        self.exchange = Exchange(self._plan, opened_s, self.port.epoch_s, self._baud)
        conversation = self.exchange.conversation
        give_up_s = opened_s + self._plan.serial.boot + ANSWER_WITHIN_S
        first_s = inf
        while not conversation.known and self.port.now() < min(give_up_s, first_s + _MORE_WITHIN_S):
            self.turn(min(give_up_s, self.port.now() + _LOOK_UP_S))
            if conversation.offered and first_s == inf:
                first_s = self.port.now()
        if not conversation.offered:
            name, usual = self.port.name, self._plan.serial.baud
            raise BackendError(unanswered(name, self._baud, conversation, self._sample, usual))
        self._answer_s = first_s - opened_s
        self._connected = True

    # --- listening --------------------------------------------------------------------------

    def listen(self, seconds: float, watch: Watch = lambda listening: None) -> None:
        """Reset the counts and listen.

        Args:
            seconds: How long to listen.
            watch: Is called ten times a second.

        Raises:
            PortLostError: The port has gone.
        """
        began_s = self.port.now()
        self._count_from(began_s)
        asked_s = began_s
        while (now := self.port.now()) < began_s + seconds:
            if now >= asked_s + _ASK_EVERY_S and self.exchange.conversation.known:
                self._ask(now)
                asked_s = now
            self.turn(min(began_s + seconds, now + _LOOK_UP_S))
            watch(self)

    def turn(self, until_s: float) -> None:
        """Write what is due, and take in what comes by then."""
        while True:
            now = self.port.now()
            while data := self._due(now):
                self.port.write(data)
            self.port.beat(self.exchange.safe_frame())
            due_s = self.exchange.due_s(now) if self._may_write else inf
            wake_s = max(now, min(until_s, due_s, now + _BEAT_EVERY_S))
            data = self.port.read(wake_s)
            self._check()
            now = self.port.now()
            self._late_s = max(self._late_s, now - wake_s)
            if data:
                self._hear(data, now)
            self._digest(self.exchange.take(), now)
            if now >= until_s:
                return

    @property
    def _may_write(self) -> bool:
        """Whether the conversation may ask; it stops asking an unintelligible device."""
        conversation = self.exchange.conversation
        return not self._connected or conversation.known or conversation.due_s == -inf

    def _due(self, now: float) -> bytes:
        return self.exchange.write(now) if self._may_write else b""

    def _ask(self, now: float) -> None:
        """Ask for the topics again, to measure the time to the answer."""
        self._asked_s = now
        self.port.write(encode(frames.REQUEST_TOPICS))

    def _hear(self, data: bytes, now: float) -> None:
        if not self._connected:
            self._sample = (self._sample + data)[-_SAMPLE_BYTES:]
        for topic, payload in self._decoder.feed(data):
            self._counts[topic] += 1
            if topic in {frames.PUBLISHER, frames.SUBSCRIBER, frames.TIME} and self._asked_s < inf:
                self._asked_ms.append((now - self._asked_s) * 1e3)
                self._asked_s = inf
            self._meet(topic, payload)
        self.exchange.receive(data, now)

    def _digest(self, events: Sequence[Event], now: float) -> None:
        for event in events:
            if isinstance(event, SensorFrame):
                self.records.take(event, now)
            elif isinstance(event, SubmitResult):
                self.results[event.setpoint_id] = event
            elif isinstance(event, FaultReport):
                self._resets += event.code == BuiltInFault.FIRMWARE_RESET.code

    def _meet(self, topic: int, payload: bytes) -> None:
        """Count the messages of boards that are not in the profile."""
        state = self._plan.wanted[STATE]
        offer = self.exchange.conversation.offered.get((state.direction, state.name.lstrip("/")))
        if offer is None or offer.number != topic or offer.md5 != state.md5:
            return
        with suppress(Malformed):
            board = self._plan.messages.state.unpack(payload).board
            if board not in self._plan.channels:
                self._strangers[board] += 1

    def _count_from(self, now: float) -> None:
        self.records = Records(self.subject, now)
        self._began_s = now
        self._base = (self.exchange.link.quality.received, self.exchange.counts)
        self._resets = 0
        self._counts: Counter[int] = Counter()
        self._strangers: Counter[int] = Counter()
        self._asked_s = inf
        self._asked_ms: list[float] = []
        self._late_s = 0.0

    # --- what came of it --------------------------------------------------------------------

    def facts(self) -> Facts:
        """Return all facts so far, without judging them."""
        now = self.port.now()
        conversation, counts = self.exchange.conversation, self.exchange.counts
        received, before = self._base
        link = LinkFact(
            answer_s=self._answer_s,
            bytes=self.exchange.link.quality.received - received,
            dropped=counts.dropped - before.dropped,
            unreadable=counts.unreadable - before.unreadable,
            strange=counts.strange - before.strange,
            damaged=counts.damaged,
            repeats=counts.repeats,
            resets=self._resets,
            time_requests=max(0, self._counts[frames.TIME] - len(self._asked_ms)),
            asked_ms=tuple(self._asked_ms),
            echoed_ms=tuple(each * 1e3 for each in self.exchange.link.quality.round_trips),
            stood_still_s=self._late_s,
        )
        return Facts(
            port=self.port.name,
            robot=self.subject.profile.robot,
            baud=self._baud,
            listened_s=now - self._began_s,
            topics=topic_facts(
                self._plan.wanted,
                conversation.offered,
                self._counts,
                max(now - self._began_s, 1e-3),
            ),
            boards=self.records.facts(now),
            # Damage that the checksum misses makes up a board now and then, not often.
            strangers=tuple(sorted(b for b, count in self._strangers.items() if count > 2)),
            link=link,
            words=tuple((line.level, line.text) for line in conversation.words),
            refused=tuple(self.exchange.refused),
        )


class OpenLink(Listening):
    """Repeats the doctor's checks on a link that a run has open; a context manager.

    It sends nothing, so it cannot know how soon the device answers, and the run does not pass on
    what boards report that are not in the profile.

    Args:
        subject: The expected robot.
        backend: The link, which must be open when this is entered.

    Attributes:
        found: What the last complete time of listening has shown, judged; None before.
    """

    def __init__(self, subject: ExpectedRobot, backend: SerialBackend) -> None:
        super().__init__(subject, backend.port, subject.plan.serial.baud)
        self._backend = backend
        self.found: Facts | None = None

    def __enter__(self) -> Self:
        """Listen from now on."""
        self.found, self.exchange = None, self._backend.exchange
        self._restart(self.port.now())
        self._backend.listener = self._listen
        return self

    def __exit__(self, *_: object) -> None:
        """Listen no longer."""
        self._backend.listener = None

    def _restart(self, now: float) -> None:
        self._count_from(now)
        self._served_s = now

    def _listen(self, events: Sequence[Event], now: float) -> None:
        self._late_s = max(self._late_s, now - self._served_s - _LOOK_UP_S)
        self._served_s = now
        self._digest(events, now)
        if now >= self._began_s + CHECKED_EVERY_S:
            self.found = judged(self.facts(), self.subject)
            self._restart(now)
