"""Whatever dies, goes away and comes back in whatever order: once the line is back wheels stand."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.robot.backends.serial.guardian.guard import (
    Action,
    EndGuardian,
    Guard,
    Instructions,
    Note,
    NoteKind,
    Reopen,
    ToPort,
    ToRunner,
)
from pirate_sm.robot.rosserial.frames import SerialFrame, encode
from pirate_sm.simulation.bay.node_handle import NodeHandle, Reception

from ..bench import ARRAY, ECHO, FIRST_PUBLISHER, FIRST_SUBSCRIBER, STATE, WANTED, topic

DRIVE, SAFE, NOTHING = b"drive", b"safe", b"after a reset nothing is driven"
STEP_S, BEAT_S, TALK_S = 0.01, 0.05, 0.04
SILENCE_S, BOOT_S, STAY_S, ECHO_S = 0.3, 0.6, 60.0, 0.05
BOUND_S = 4.0
"""To open the port, to wait for the boot loader, to be introduced twice, to be echoed."""


@dataclass
class Device:
    """A controller that continues with what it was told until it is told something else."""

    resets: bool
    shift: int = 0
    array: bytes = DRIVE
    up_s: float = 0.0
    faults: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.says: list[tuple[float, SerialFrame]] = []
        self.start(0.0, configured=True)

    def start(self, now: float, *, configured: bool = False) -> None:
        publishers = [
            topic(FIRST_PUBLISHER + self.shift + place, name)
            for place, name in enumerate((ECHO, STATE))
        ]
        self.node = NodeHandle(publishers, (topic(FIRST_SUBSCRIBER + self.shift, ARRAY),))
        self.reception = Reception()
        self.says.clear()
        if configured:
            self.node.take(SerialFrame(0, b""), now)

    def open(self, now: float) -> None:
        if self.resets:
            self.up_s = now + BOOT_S
            self.start(now)

    def receive(self, data: bytes, now: float) -> None:
        if now < self.up_s:
            return
        for frame in self.reception.feed((byte, now) for byte in data):
            answer = self.node.take(frame, now)
            self.faults += [answer.fault] if answer.fault else []
            self.says += [(now + ECHO_S / 2, said) for said in answer.says]
            if frame.topic == FIRST_SUBSCRIBER + self.shift:
                self.array = frame.payload
                if self.node.configured:
                    echo = SerialFrame(FIRST_PUBLISHER + self.shift, frame.payload)
                    self.says.append((now + ECHO_S, echo))

    def run(self, now: float, before_s: float) -> bytes:
        if before_s < self.up_s <= now:
            self.array = NOTHING
        if now < self.up_s:
            return b""
        due = [said for at_s, said in self.says if at_s <= now]
        self.says = [each for each in self.says if each[0] > now]
        due += self.node.tick(now)
        if self.node.configured and int(now / TALK_S) != int(before_s / TALK_S):
            due.append(SerialFrame(FIRST_PUBLISHER + self.shift + 1, b"state"))
        return b"".join(encode(*frame) for frame in due)


class World:
    """Guard, runner, line and device in one time."""

    def __init__(self, resets: bool) -> None:
        self.now = 0.0
        self.device = Device(resets)
        self.guard = Guard(Instructions(SILENCE_S, WANTED, BOOT_S, STAY_S), 0.0)
        self.plugged = self.alive = self.beats = True
        self.to_device = self.to_host = True
        self.finished: EndGuardian | None = None
        self.alone_s = 0.0
        self.beat_s = -1.0
        self.overruled = self.asleep = False
        self.do(self.guard.opened(0.0))
        self.do(self.guard.hear(Note(NoteKind.WRITE, encode(FIRST_SUBSCRIBER, DRIVE)), 0.0))

    def do(self, actions: list[Action]) -> None:
        for action in actions:
            if isinstance(action, ToPort) and self.plugged and self.to_device:
                self.device.receive(action.data, self.now)
            elif isinstance(action, ToRunner) and action.note.kind == NoteKind.OVERRULED:
                self.overruled = True
            elif isinstance(action, Reopen):
                if self.plugged:
                    self.device.open(self.now)
                    self.do(self.guard.opened(self.now))
                else:
                    self.do(self.guard.refused("not there", self.now))
            elif isinstance(action, EndGuardian):
                self.finish(action)

    def finish(self, action: EndGuardian) -> None:
        self.finished = action
        if action.stopped:
            assert self.device.array != DRIVE, "it finished while wheels were driven"
        else:
            assert self.now >= self.alone_s + STAY_S - STEP_S, "it gave up before its time"

    def happen(self, event: str) -> None:
        if "port" in event or "line" in event or "device" in event:
            self._befall_line(event)
        elif event == "the runner dies" and self.alive:
            self.alive, self.alone_s = False, self.now
            self.do(self.guard.runner_gone(self.now))
        elif "guardian" in event:
            self.asleep = event.endswith("still")
        else:
            self.beats = event.endswith("goes on")

    def _befall_line(self, event: str) -> None:
        match event:
            case "the port goes" if self.plugged:
                self.plugged = False
                self.do(self.guard.lost("gone", self.now))
            case "the port returns":
                self.plugged = True
            case "the port returns with other numbers" if not self.plugged:
                self.plugged, self.device.shift = True, self.device.shift + 1
                self.device.start(self.now)
            case "nothing reaches the device":
                self.to_device = False
            case "nothing comes from the device":
                self.to_host = False
            case "the line is good":
                self.to_device = self.to_host = True

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            if self.finished is not None:
                return
            before_s, self.now = self.now, self.now + STEP_S
            data = self.device.run(self.now, before_s)
            if self.asleep:
                continue
            if self.alive and self.beats and self.now >= self.beat_s + BEAT_S:
                self.beat_s = self.now
                if self.overruled:
                    self.overruled = False
                    self.do(self.guard.hear(Note(NoteKind.HEED), self.now))
                beat = Note(NoteKind.BEAT, encode(FIRST_SUBSCRIBER, SAFE))
                self.do(self.guard.hear(beat, self.now))
            if data and self.plugged and self.to_host:
                self.do(self.guard.receive(data, self.now))
            if self.finished is None:
                self.do(self.guard.tick(self.now))


class Happening(NamedTuple):
    """What happens, and how long nothing else does."""

    event: str
    lasts_s: float


EVENTS = (
    "the runner dies",
    "the runner stalls",
    "the runner goes on",
    "the guardian stands still",
    "the guardian goes on",
    "the port goes",
    "the port returns",
    "the port returns with other numbers",
    "nothing reaches the device",
    "nothing comes from the device",
    "the line is good",
)
HAPPENINGS = st.builds(
    Happening,
    st.sampled_from(EVENTS),
    st.sampled_from((0.0, 0.01, 0.05, 0.12, 0.35, 0.7, 1.5, 3.0)),
)


@given(schedule=st.lists(HAPPENINGS, max_size=12), resets=st.booleans())
def test_once_the_line_is_back_nothing_is_driven_and_nobody_leaves_before(
    schedule: list[Happening], resets: bool
) -> None:
    world = World(resets)
    world.run(0.2)
    for happening in schedule:
        if world.finished is None:
            world.happen(happening.event)
            world.run(happening.lasts_s)
    if world.finished is None:
        for event in ("the runner dies", "the guardian goes on", "the line is good"):
            world.happen(event)
        world.happen("the port returns")
        world.run(BOUND_S)

    assert world.finished == EndGuardian(stopped=True)
    assert world.device.array != DRIVE
    assert world.device.faults == [], "a number that the device had not given"


@settings(max_examples=20)
@given(event=st.sampled_from(EVENTS[5:6] + EVENTS[8:10]), resets=st.booleans())
def test_while_the_line_is_not_back_it_stays_until_its_time_is_over(
    event: str, resets: bool
) -> None:
    world = World(resets)
    world.run(0.2)
    world.happen(event)
    world.happen("the runner dies")
    world.run(STAY_S - 1.0)
    assert world.finished is None
    world.run(2.0)

    assert world.finished == EndGuardian(stopped=False)
