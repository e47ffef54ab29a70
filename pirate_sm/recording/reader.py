"""Recordings are read again, also those of runs that were cut short.

``read_recording(path).steps()`` gives everything that the engine was given, in order, and what came
of it. Only the piece that is being read is in memory, so a recording may be of any length; where
it holds checkpoints, :meth:`Recording.checkpoint`, reading can begin in the middle.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from hashlib import file_digest
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any, Literal, NamedTuple

from pirate_sm import __version__
from pirate_sm.engine.robot.robot_state import RobotState
from pirate_sm.engine.state import EngineState
from pirate_sm.errors import RecordingError
from pirate_sm.loading.file_names import shown
from pirate_sm.model.effects import Effect, Ended, WaitArmed
from pirate_sm.model.events import Event
from pirate_sm.recording.alphabet import ENGINE, STATE, Abandoned, Started, Topic, Topics
from pirate_sm.recording.beginning import DamagedInsideError, read_header
from pirate_sm.recording.bodies import body_from_text
from pirate_sm.recording.chunks import Chunks, Message
from pirate_sm.recording.header import PROFILE, REPAIRED, RunHeader
from pirate_sm.recording.mcap_records import Content, DamagedError, NotMcapError, read_content
from pirate_sm.recording.states import state_from_text

NS_PER_S = 1_000_000_000

_NO_INDEX = (
    "all that was recorded is there, but the index at the end of the file, which other programs "
    "look for, is missing or damaged: pirate repair makes it anew"
)


class Step(NamedTuple):
    """Something that the engine was given, and what it gave back.

    Attributes:
        number: Its place in the recording, from 0.
        at_s: When it was on the clock that the engine was given. The runs of a console's session
            share that clock: see :attr:`Recording.origin_s`.
        event: What the engine was given; None for its start and where it was not asked.
        effects: What it gave back; those of the program around it where it was not asked.
        by: ``seen``: shown to the engine at its start, which comes after it. ``start``: the start
            itself. ``engine``: a step of it. ``runtime``: the engine was given up.
        body: Of a start: what an earlier mission had commanded the robot to.
        paused: Of a start: whether the operator had the robot first.
        state: What the engine remembered after it, where the recording says so.
    """

    number: int
    at_s: float
    event: Event | None
    effects: tuple[Effect, ...]
    by: Literal["seen", "start", "engine", "runtime"]
    body: RobotState | None = None
    paused: bool = False
    state: EngineState | None = None


class Told(NamedTuple):
    """What came of the step of this number; ``at_s`` is the time since the run began."""

    number: int
    at_s: float
    effects: tuple[Effect, ...]


class Shown(NamedTuple):
    """A message that was made for viewers."""

    topic: str
    at_s: float
    content: dict[str, Any]


class Checkpoint(NamedTuple):
    """The engine's state in the middle of a run, from where it can be executed again.

    Attributes:
        step: The step after which the state was such.
        at_s: When that was, time since the run began.
        state: What the engine remembered then.
        place: Number of the piece of the file that holds it.
    """

    step: int
    at_s: float
    state: EngineState
    place: int = 0


def _nobody(share: float) -> None:
    """Nobody is told."""


@dataclass(frozen=True)
class Recording:
    """A recording whose beginning has been read.

    Attributes:
        path: Of its file.
        header: What was run, with every text that it was made from.
        content: Where everything is in the file.
        watch: Receives how much of the recording has been read, from 0 to 1.
    """

    path: Path
    header: RunHeader
    content: Content = field(repr=False)
    watch: Callable[[float], None] = field(default=_nobody, repr=False)

    @property
    def complete(self) -> bool:
        """Whether it was written to its end by the run."""
        return self.content.complete and REPAIRED not in self.content.metadata

    @cached_property
    def notices(self) -> tuple[str, ...]:
        """What a person should know although it can be read.

        Raises:
            RecordingError: It is damaged.
        """
        if self.complete:
            return () if self.content.indexed else (_NO_INDEX,)
        if not self.until_s:
            return ("the recording ends early, as the run began",)
        if self._ended:
            return (f"the end of the file is lost, but the run had ended, at {self.until_s:.3f} s",)
        return (f"the recording ends early, at {self.until_s:.3f} s: nothing after that is in it",)

    @cached_property
    def origin_s(self) -> float:
        """Return when the run began on the clock that the engine was given, 0 where nothing is.

        All other times of a recording count from then, those of its steps apart.

        Raises:
            RecordingError: It is damaged.
        """
        for _, entries in self._pieces(0):
            inputs = [(self._by_name.get(name), data) for name, _, data in entries]
            times_s = (
                at_s
                for topic, data in inputs
                if topic is not None and topic.is_input
                for _, at_s, *_ in self._decoded(topic, data)
            )
            first_s = min(times_s, default=None)
            if first_s is not None:
                return first_s
        return 0.0

    @cached_property
    def until_s(self) -> float:
        """Until when it holds: time of the last step in it, 0 where there is none.

        Raises:
            RecordingError: It is damaged.
        """
        return self._last_steps[-1].at_s - self.origin_s if self._last_steps else 0.0

    @cached_property
    def _ended(self) -> bool:
        """Whether the end of the run is in it."""
        last = (effect for step in self._last_steps for effect in step.effects)
        return any(isinstance(effect, Ended) for effect in last)

    @cached_property
    def _last_steps(self) -> list[Step]:
        """The steps of the last piece that has any."""
        pieces = reversed(range(len(self.content.pieces)))
        found = (self._rows(self._read(place), None) for place in pieces)
        return next(filter(None, found), [])

    @cached_property
    def sha256(self) -> str:
        """The hash of the file, hexadecimal.

        Raises:
            RecordingError: It cannot be read.
        """
        try:
            with self.path.open("rb") as file:
                return file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise _unreadable(self.path, error) from None

    @cached_property
    def starts_s(self) -> list[float]:
        """When each piece of the file begins."""
        return [self._time_s(piece.start_ns) for piece in self.content.pieces]

    def checkpoint(self, at_s: float) -> Checkpoint | None:
        """The last checkpoint up to this time; None where there is none that can be used.

        Only the version that recorded can use one: another one may number its states otherwise.

        Raises:
            RecordingError: It is damaged.
        """
        for place in reversed(range(bisect_right(self.starts_s, at_s))):
            found = [each for each in self._checkpoints(place) if each.at_s <= at_s]
            if found:
                return found[-1]
        return None

    def checkpoints(self, after: Checkpoint | None = None) -> Iterator[Checkpoint]:
        """Every checkpoint that can be used, in order.

        Args:
            after: Only those that come after this one; None: all.

        Raises:
            RecordingError: It is damaged.
        """
        for place in range(after.place if after else 0, len(self.content.pieces)):
            for each in self._checkpoints(place):
                if after is None or each.step > after.step:
                    yield each

    def steps(self, after: Checkpoint | None = None) -> Iterator[Step]:
        """Everything that the engine was given, in order, and what came of it.

        Args:
            after: Where to begin; None: at the beginning.

        Raises:
            RecordingError: It is damaged.
        """
        started = after is not None
        for rows in self.commits(after):
            for step in rows:
                started = started or step.by == "start"
                yield step if started or step.by != "engine" else step._replace(by="seen")

    def commits(self, after: Checkpoint | None = None) -> Iterator[list[Step]]:
        """The steps of each piece, in order; those before the start are taken for the engine's.

        Args:
            after: Where to begin; None: at the beginning.

        Raises:
            RecordingError: It is damaged.
        """
        first, number = (after.place, after.step + 1) if after is not None else (0, 0)
        for place, entries in self._pieces(first):
            rows = self._rows(entries, number if place > first or after is None else None)
            steps = [step for step in rows if step.number >= number]
            number += len(steps)
            yield steps

    def effects(self) -> Iterator[Told]:
        """All that the engine gave back, in order: sooner read than the steps that it came of.

        Raises:
            RecordingError: It is damaged.
        """
        for _, entries in self._pieces(0):
            rows: list[tuple[int, int, float, Effect]] = []
            for name, _, data in entries:
                topic = self._by_name.get(name)
                if topic is not None and not topic.is_input:
                    rows += [
                        (number, nth, at_s, made)
                        for number, at_s, nth, made in self._decoded(topic, data)
                    ]
            rows.sort(key=lambda row: row[:2])
            for number, same_step in groupby(rows, key=lambda row: row[0]):
                given = list(same_step)
                made_of = tuple(row[3] for row in given)
                at_s = given[0][2] - self.origin_s
                yield Told(number, at_s, with_own_times(made_of, self.origin_s))

    def shown(self, *topics: str, since_s: float = -inf) -> Iterator[Shown]:
        """What was made for viewers, in order: of these topics, or of all.

        Args:
            topics: Their names.
            since_s: Of what was before this time only the newest may come.

        Raises:
            RecordingError: It is damaged.
        """
        for _, entries in self._pieces(max(bisect_right(self.starts_s, since_s) - 2, 0)):
            for topic, time_ns, data in entries:
                if topic in topics if topics else not topic.startswith(ENGINE):
                    yield Shown(topic, self._time_s(time_ns), json.loads(data))

    @cached_property
    def _by_name(self) -> dict[str, Topic]:
        return Topics(self.header.layout).by_name

    @cached_property
    def _zero_ns(self) -> int:
        """When the run began: messages of later runs of a session once counted from the first."""
        if self.content.pieces:
            return self.content.pieces[0].start_ns
        return round(datetime.fromisoformat(self.header.began).timestamp() * NS_PER_S)

    def _time_s(self, time_ns: int) -> float:
        return (time_ns - self._zero_ns) / NS_PER_S

    def _checkpoints(self, place: int) -> Iterator[Checkpoint]:
        """Those in a piece that this version of the engine can use."""
        for topic, _, data in self._read(place):
            if topic == STATE.name:
                yield from self._remembered(data, place)

    def _remembered(self, data: bytes, place: int = 0) -> Iterator[Checkpoint]:
        """The checkpoints of a message; none where another version has written it."""
        if self.header.version != __version__:
            return
        for step, at_s, _, made in self._decoded(STATE, data):
            with suppress(ValueError):
                own_s = at_s - self.origin_s
                yield Checkpoint(step, own_s, state_from_text(made.state), place)

    def _pieces(self, first: int) -> Iterator[tuple[int, list[Message]]]:
        """Number and messages of each piece, which holds whole steps."""
        for place in range(first, len(self.content.pieces)):
            self.watch(self.content.pieces[place].at / self.content.size)
            yield place, self._read(place)
        self.watch(1.0)

    def _read(self, place: int) -> list[Message]:
        """The messages of a piece."""
        try:
            return self._chunks.read(place)
        except DamagedError as error:
            raise DamagedInsideError(self.path, str(error)) from None
        except OSError as error:
            raise _unreadable(self.path, error) from None

    @cached_property
    def _chunks(self) -> Chunks:
        return Chunks(self.path, self.content.pieces)

    def _decoded(self, topic: Topic, data: bytes) -> Iterator[tuple[int, float, int, Any]]:
        """Step, time, place and content of each row of a message."""
        try:
            yield from topic.decode(data)
        except ValueError as error:
            raise DamagedInsideError(self.path, str(error)) from None

    def _rows(self, entries: Sequence[Message], first: int | None) -> list[Step]:
        """The steps among messages; ``first``: the number of the first of them, None: any."""
        inputs: dict[int, tuple[float, Any]] = {}
        effects: dict[int, list[tuple[int, Effect]]] = defaultdict(list)
        states: dict[int, EngineState] = {}
        for name, _, data in entries:
            if name == STATE.name:
                states |= {each.step: each.state for each in self._remembered(data)}
            topic = self._by_name.get(name)
            if topic is None:
                continue
            for number, at_s, place, made in self._decoded(topic, data):
                if topic.is_input:
                    inputs[number] = (at_s, made)
                else:
                    effects[number].append((place, made))
        if first is None:
            first = min(inputs, default=0)
        if inputs.keys() != set(range(first, first + len(inputs))) or effects.keys() - inputs:
            raise DamagedInsideError(self.path, f"steps are missing after the first {first}")
        try:
            steps = [_step(number, *inputs[number], effects[number]) for number in sorted(inputs)]
        except ValueError as error:
            raise DamagedInsideError(self.path, str(error)) from None
        if states:
            return [step._replace(state=states.get(step.number)) for step in steps]
        return steps


def with_own_times(effects: tuple[Effect, ...], origin_s: float) -> tuple[Effect, ...]:
    """Return the effects with deadlines that count from the origin of a recording."""
    found = []
    for each in effects:
        if isinstance(each, WaitArmed):
            each = each._replace(deadline_s=each.deadline_s - origin_s)  # noqa: PLW2901
        found.append(each)
    return tuple(found)


def _step(number: int, at_s: float, made: Any, effects: list[tuple[int, Effect]]) -> Step:
    given = tuple(effect for _, effect in sorted(effects, key=lambda each: each[0]))
    if isinstance(made, Started):
        return Step(number, at_s, None, given, "start", body_from_text(made.body), made.paused)
    if isinstance(made, Abandoned):
        return Step(number, at_s, None, given, "runtime")
    return Step(number, at_s, made, given, "engine")


def read_recording(
    path: Path, watch: Callable[[float], None] = _nobody, *, damaged: bool = False
) -> Recording:
    """The recording in this file, as far as it goes.

    Args:
        path: The file.
        watch: Receives how much of it has been read, whenever it is read.
        damaged: Whether one will do that is damaged, up to where it is.

    Raises:
        RecordingError: There is none, it is something else, or its beginning is damaged.
    """
    try:
        with path.open("rb") as file:
            content = read_content(file)
    except NotMcapError:
        raise RecordingError(f"{shown(path)} is not a recording: it is not an MCAP file") from None
    except OSError as error:
        raise _unreadable(path, error) from None
    except ValueError:
        raise RecordingError(f"there is no file '{shown(path)}'") from None
    if content.profile not in (PROFILE, None):
        raise RecordingError(f"{shown(path)} is an MCAP file, but not a recording of a mission")
    recording = Recording(path, read_header(path, content), content, watch)
    if content.damage and not damaged:
        raise DamagedInsideError(path, content.damage)
    return recording


def _unreadable(path: Path, error: OSError) -> RecordingError:
    return RecordingError(f"{shown(path)} cannot be read: {error.strerror}")
