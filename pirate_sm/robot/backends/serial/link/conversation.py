"""The host's side of rosserial: learns and checks topics, answers for the time, notices silence.

Pure: bytes and the time go in, frames to write come out. An 8-bit checksum lets some damage
through, so an introduction counts only when it has come twice with the same content. What makes
a connection fail is explained in one sentence, with what to do.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf, isnan, nan
from typing import NamedTuple, TypeAlias

from pirate_sm.robot.rosserial.frames import (
    FIRST_OF_THE_DEVICE,
    LOG,
    LONGEST_PAYLOAD,
    PUBLISHER,
    REQUEST_TOPICS,
    SUBSCRIBER,
    TIME,
    TX_STOP,
    Decoder,
    Direction,
    LogLine,
    SerialFrame,
    TopicInfo,
    encode,
    read_log,
    read_topic,
    time_payload,
)

# --- silence --------------------------------------------------------------------------------------


_OVERSLEPT = 2.0
"""A look that is this many intervals late shows that this process did not run in between."""

_LEAST_S = 1e-3
"""The shortest wait. Without it, rounding could make the last wait zero forever."""


class SilenceTimer:
    """Measures the silence of another process by looks at regular intervals.

    When the whole computer stands still, both processes do, and the first to wake would take the
    other for dead. A standstill of our own therefore restarts the measurement, once until the
    other side is heard: it gets the time for one more message.

    Args:
        nap_s: The longest time between two looks.
    """

    def __init__(self, nap_s: float) -> None:
        self._nap_s = nap_s
        self.hear(-inf)

    def hear(self, now: float) -> None:
        """Begin the measurement: the other side has been heard."""
        self._looked_s, self._waited_s, self._spared = now, 0.0, False

    def look(self, now: float) -> float:
        """Return how long the other side has been silent while we were awake, s."""
        gap_s, self._looked_s = now - self._looked_s, now
        if gap_s <= _OVERSLEPT * self._nap_s:
            self._waited_s += gap_s
        elif self._spared:
            self._waited_s += self._nap_s
        else:
            self._spared, self._waited_s = True, 0.0
        return self._waited_s

    def due_s(self, limit_s: float) -> float:
        """Return when to look next, to notice a silence of ``limit_s`` in time."""
        return self._looked_s + min(self._nap_s, max(_LEAST_S, limit_s - self._waited_s))


# --- wanted topics --------------------------------------------------------------------------------


class Wanted(NamedTuple):
    """A topic that the robot's profile names.

    Attributes:
        direction: What the device does with it.
        text: Our definition, for people.
        longest: Bytes of its longest payload.
        answers: The device only sends it to answer a writing. So it does not show that the device
            works of its own accord, and does not end a silence.
    """

    name: str
    type: str
    md5: str
    direction: Direction
    text: str = ""
    longest: int = LONGEST_PAYLOAD
    answers: bool = False


class TopicPayload(NamedTuple):
    """A payload on the wanted topic with index ``which``."""

    which: int
    payload: bytes


class TopicsKnown(NamedTuple):
    """Event: all wanted topics are known.

    Attributes:
        again: They had been known before; the device had to be asked anew.
        silence_s: How long the device had been silent.
    """

    again: bool
    silence_s: float


class TopicRefused(NamedTuple):
    """Event: a topic is not used, because the device defines it differently."""

    reason: str


Heard: TypeAlias = TopicPayload | TopicsKnown | TopicRefused | LogLine


def difference(wanted: Wanted, info: TopicInfo) -> str:
    """Return how the device's definition differs from ours, as text for people."""
    if wanted.type != info.type:
        return (
            f"the device says that topic '{info.name}' carries {info.type}, "
            f"the robot's profile says {wanted.type}"
        )
    return (
        f"the firmware's {info.type} is another one than ours: its md5 is {info.md5}, that of our "
        f"text {wanted.md5}. Put the .msg text of the firmware instead of this program's, "
        f"which is:\n"
        f"{wanted.text}"
    )


# --- the conversation -----------------------------------------------------------------------------


ASK_EVERY_S = 0.1
"""The interval at which a booting device is asked again; its whole answer takes half of it."""

SILENT_AFTER_S = 0.4
"""After a reset a device waits to be asked; a healthy one would have sent 25 frames by then."""

_LOOKS = 4
"""How often the silence of a device is measured before it counts as silent."""

_WORDS_KEPT = 20

_ROOM_FOR_WORDS = 128
"""Bytes that an introduction or a line of the firmware's log may always have."""


class Conversation:
    """One connection to a device.

    Attributes:
        known: Whether every wanted topic is known.
        frames: Frames received.
        words: The last lines of the firmware's log.
        recent: Those of them since it last fell silent: another device may speak now.
        heard_s: When the last frame came that the device sent of its own accord.
        silence_s: How long nothing had come before that frame, while this program was awake. While
            the device is asked anew: before any frame since the silence began.
        offered: Every topic that the device has introduced, by direction and name.
        strange: Frames on topics that were never introduced.
    """

    def __init__(
        self,
        wanted: Sequence[Wanted],
        now: float,
        epoch_s: float = 0.0,
        boot_s: float = 0.0,
        silent_s: float = SILENT_AFTER_S,
    ) -> None:
        """Begin a connection on which nothing has been received.

        Args:
            wanted: The required topics.
            now: The time.
            epoch_s: Added to the time it gives the device's time, seconds since 1970.
            boot_s: How long a boot loader may be listening; nothing may be sent until then.
            silent_s: A device that has been silent for this long is asked anew. Time in which this
                program stood still does not count.
        """
        self._wanted = tuple(wanted)
        self._silent_s = silent_s
        self._patience = SilenceTimer(silent_s / _LOOKS)
        self._patience.hear(now)
        self._decoder = Decoder()
        self._numbers: dict[int, int] = {}
        self._rooms: dict[int, int] = {}
        self._unproven: Counter[TopicInfo] = Counter()
        self._refused: set[int] = set()
        self._time = TimeAnswers(epoch_s)
        self._ask_s = now + boot_s
        self.known = False
        self._again = False
        self._fresh: set[int] = set()
        self._silence_s = 0.0
        self.heard_s = now
        self.silence_s = 0.0
        self.frames = 0
        self.strange = 0
        self.words: deque[LogLine] = deque(maxlen=_WORDS_KEPT)
        self.recent: deque[LogLine] = deque(maxlen=_WORDS_KEPT)
        self.offered: dict[tuple[Direction, str], TopicInfo] = {}

    @property
    def asking(self) -> bool:
        """Whether the device is being asked to introduce itself."""
        return not self.known or self._again

    @property
    def dropped(self) -> int:
        """Bytes that belonged to no frame."""
        return self._decoder.dropped

    @property
    def missing(self) -> tuple[Wanted, ...]:
        """The wanted topics that the device has not introduced with our definition."""
        known = set(self._numbers.values())
        return tuple(each for at, each in enumerate(self._wanted) if at not in known)

    @property
    def due_s(self) -> float:
        """When there is something to write, if nothing comes before."""
        due = self._ask_s if self.asking else self._patience.due_s(self._silent_s)
        return min(due, self._time.due_s)

    def write(self, now: float) -> bytes:
        """Return the next frame to write at this time; empty if there is none."""
        silent = self._patience.look(now) >= self._silent_s
        if now >= self._time.due_s:
            return self._time.answer()
        if self.known and not self._again and silent:
            self._again = True
            self._fresh.clear()
            self.recent.clear()
            self._ask_s = now
        if self.asking and now >= self._ask_s:
            self._ask_s = now + ASK_EVERY_S
            return encode(REQUEST_TOPICS)
        return b""

    def frame(self, which: int, payload: bytes) -> bytes:
        """Return the frame with a payload on a wanted topic; empty if it must not be sent.

        A device overwrites its own memory with a payload that is too long or on a topic that it
        does not have.
        """
        for number, at in self._numbers.items():
            if at == which and self._wanted[at].direction == "takes":
                return encode(number, payload) if len(payload) <= self._rooms[at] else b""
        return b""

    def farewell(self) -> bytes:
        """Return the frame after which the device stops publishing."""
        return encode(TX_STOP)

    def receive(self, data: bytes, now: float) -> Iterator[Heard]:
        """Decode these bytes and yield what they contain, one item at a time."""
        self._decoder.longest = self._longest
        for frame in self._decoder.feed(data):
            yield from self._take(frame, now)

    @property
    def _longest(self) -> int:
        """The length of the longest payload that is expected now, bytes.

        While a device is asked, or if it has further topics, it may send payloads of any length.
        """
        wanted = {(each.direction, each.name.lstrip("/")) for each in self._wanted}
        others = (info for key, info in self.offered.items() if key not in wanted)
        if self.asking or any(self._unproven[info] > 1 for info in others):
            return LONGEST_PAYLOAD
        published = (each.longest for each in self._wanted if each.direction == "publishes")
        return max((_ROOM_FOR_WORDS, *published))

    def _take(self, frame: SerialFrame, now: float) -> Iterator[Heard]:
        topic, payload = frame
        at = self._numbers.get(topic)
        if at is None and topic not in {PUBLISHER, SUBSCRIBER, LOG, TIME}:
            self.strange += topic >= FIRST_OF_THE_DEVICE
            return  # proves nothing: damaged, or not rosserial
        self.frames += 1
        if at is not None and self._wanted[at].answers:
            yield TopicPayload(at, payload)
            return
        self._silence_s, self.heard_s = max(self._silence_s, now - self.heard_s), now
        self.silence_s = max(self.silence_s if self._again else 0.0, self._patience.look(now))
        self._patience.hear(now)
        if at is not None:
            if not (self._again and self._fresh):
                self._silence_s = 0.0
                self._again = False  # the device never stopped: the link was silent
            yield TopicPayload(at, payload)
        elif topic in {PUBLISHER, SUBSCRIBER}:
            yield from self._meet(read_topic(topic, payload))
            if self.known and not self._time.requested:
                self._time.request(now)  # its request was lost
        elif topic == TIME:
            self._time.request(now)
        else:
            line = read_log(payload)
            if line is not None:
                self.words.append(line)
                self.recent.append(line)
                yield line

    def _meet(self, info: TopicInfo | None) -> Iterator[Heard]:
        """Handle the device's introduction of one of its topics."""
        if info is None:
            return
        self._unproven[info] += 1
        self.offered[info.direction, info.name] = info
        for at, wanted in enumerate(self._wanted):
            if (wanted.name.lstrip("/"), wanted.direction) != (info.name, info.direction):
                continue
            if self._unproven[info] < 2:
                continue
            if (wanted.type, wanted.md5) == (info.type, info.md5):
                self._numbers = {n: a for n, a in self._numbers.items() if a != at}
                self._numbers[info.number] = at
                self._rooms[at] = info.buffer_bytes
                self._fresh.add(at)
            elif at not in self._refused:
                self._refused.add(at)
                yield TopicRefused(difference(wanted, info))
        complete = set(self._numbers.values()) == set(range(len(self._wanted)))
        if complete and (not self.known or (self._again and len(self._fresh) == len(self._wanted))):
            known = TopicsKnown(self.known, self._silence_s)
            self.known, self._again, self._silence_s = True, False, 0.0
            yield known


TIME_PERIOD_S = 2.5
"""A configured device requests the time this often, and stops after 11 s without an answer."""

_TIME_COPIES = 3
_TIME_AGAIN_S = 0.4


class TimeAnswers:
    """Makes the answers to requests for the time, and says when the next is due.

    Each request is answered more than once, and an overdue request is answered as well, because a
    device without answers stops publishing.

    Args:
        epoch_s: Added to the time it gives the device's time, seconds since 1970.

    Attributes:
        due_s: When the next answer is due; infinite before the first request.
    """

    def __init__(self, epoch_s: float) -> None:
        self.due_s = inf
        self._epoch_s = epoch_s
        self._asked_s = nan
        self._copies = 0

    @property
    def requested(self) -> bool:
        """Whether the device has ever requested the time."""
        return not isnan(self._asked_s)

    def request(self, now: float) -> None:
        """Handle the device's request for the time."""
        self._asked_s = self.due_s = now
        self._copies = 0

    def answer(self) -> bytes:
        """Return the frame that answers the last request; the device adds the time since then."""
        asked_s = self._asked_s
        self._copies += 1
        if self._copies < _TIME_COPIES:
            self.due_s = asked_s + self._copies * _TIME_AGAIN_S
        else:
            self._asked_s, self._copies = asked_s + TIME_PERIOD_S, 0
            self.due_s = self._asked_s + _TIME_AGAIN_S  # unless it requests it before
        return encode(TIME, time_payload(self._epoch_s + asked_s))


# --- why a connection fails -----------------------------------------------------------------------


NO_SENSORS = "the robot's controller answers but no board sends any value"

_TEXT_SHARE = 0.9
_SHOWN = 40


def unanswered(
    port: str, baud: int, conversation: Conversation, sample: bytes, usual_baud: int | None = None
) -> str:
    """Return why the required topics have not been introduced.

    Args:
        port: Name of the port.
        baud: Baud rate of the line.
        conversation: The conversation so far.
        sample: The last bytes received.
        usual_baud: The baud rate in the robot's profile.
    """
    if conversation.frames:
        return _incomplete(port, conversation)
    if usual_baud not in {None, baud} and not sample:
        return (
            f"nothing answers on {port} at {baud} baud: the robot's profile says that its firmware "
            f"speaks {usual_baud}"
        )
    if not sample:
        return (
            f"nothing answers on {port} at {baud} baud: is this the robot's port, is it switched "
            "on, does its firmware speak rosserial at this speed?"
        )
    printable = sum(32 <= byte < 127 or byte in b"\r\n\t" for byte in sample)
    if printable >= _TEXT_SHARE * len(sample):
        shown = " ".join(sample.decode("ascii", "replace").split())[:_SHOWN]
        return f"{port} does not speak rosserial, it sends '{shown}': another device?"
    return (
        f"{port} sends bytes that make no sense at {baud} baud: the firmware uses another speed "
        "(option baud), or it is another device"
    )


def _incomplete(port: str, conversation: Conversation) -> str:
    missing = ", ".join(
        f"{each.name} ({each.type}, which it {each.direction})" for each in conversation.missing
    )
    offered = sorted(
        f"{info.name} ({info.type}, which it {info.direction})"
        for info in conversation.offered.values()
    )
    there = ", ".join(offered) if offered else "no topic at all"
    return (
        f"the device on {port} speaks rosserial but does not announce {missing}. It offers "
        f"{there}: put its names and types into section 'serial' of the robot's profile"
    )


def no_sensors(advice: str) -> str:
    """Return the message that no board reports; ``advice`` is the profile's, or empty."""
    return f"{NO_SENSORS}: {sensors_off(advice)}"


def sensors_off(advice: str) -> str:
    """Return what a person can do when no board reports; ``advice`` may be empty."""
    return advice or "are the sensors switched on, are the boards powered?"


def mute(modules: Mapping[int, str], silent: Iterable[int]) -> str:
    """Return which boards do not report."""
    names = ", ".join(f"{board} ({modules[board]})" for board in sorted(silent))
    return f"no values come from board {names}"
