"""Writes a run down while it goes on, beside it: the run itself only notes what happened.

A thread of its own makes bytes of the notes and waits for the disk, so that neither slows the loop
down. Whatever breaks there ends the recording, never the run; ``failure`` says so.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any, NamedTuple

from pirate_sm.engine.robot.robot_state import RobotState
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import Event
from pirate_sm.recording.alphabet import (
    STATE,
    Abandoned,
    Input,
    Remembered,
    Started,
    Topic,
    Topics,
)
from pirate_sm.recording.bodies import body_to_text
from pirate_sm.recording.file import RecordingFile
from pirate_sm.recording.header import RunHeader
from pirate_sm.recording.side_channel import Sample, SideChannel
from pirate_sm.recording.states import state_to_text

COMMIT_S = 0.25
"""So often what has happened goes to the disk; half a second is promised."""

CHECKPOINT_S = 60.0
"""So much mission time at most lies between two checkpoints, from where a reader can begin."""

_EARLIER = 0.8
"""A run that makes bytes itself cuts them a little before the thread would."""

_BATCH_S = 2.0
"""So much mission time at most is in one message."""

_MOST_STEPS = 20_000
"""So many steps at most are in one commit."""

_HELP_AT = 2_000
"""From so many notes on a run that is in no hurry makes bytes of them itself."""

_MOST_NOTES = 200_000
"""So many notes at most wait for the thread where a robot must not wait."""

_MOST_BYTES = 1 << 28
"""So many bytes at most wait for the disk."""

_PATIENCE_S = 20.0
"""How long the end of a run waits for the disk."""


class Note(NamedTuple):
    """Something that the run has noted."""

    event: Input
    at_s: float
    effects: Sequence[Effect]


class Checkpoint(NamedTuple):
    """What the engine remembers after the note that comes before."""

    at_s: float
    state: EngineState


class _Piece(NamedTuple):
    """What is to be written in one go; it ends with what happened at this time."""

    data: bytes
    until_s: float | None


class Recorder:
    """Is told everything that the engine is given and gives back, and keeps it.

    Args:
        file: Where to.
        header: What stands at its beginning.
        real_time: Whether a robot waits for the run. If none does, the run lends a hand when it is
            faster than the thread: two threads of one interpreter hinder each other.
        side: What is written for viewers besides.
        commit_s: How often, on the wall's clock, everything is brought to the disk.

    Attributes:
        failure: Why nothing is recorded any more; empty while all is well.
        kept_s: Until when everything is in the file, mission time; None before anything is.
        begun: Whether anything has been noted.
    """

    def __init__(
        self,
        file: RecordingFile,
        header: RunHeader,
        *,
        real_time: bool,
        side: SideChannel | None = None,
        commit_s: float = COMMIT_S,
    ) -> None:
        self.failure = ""
        self.kept_s: float | None = None
        self.begun = False
        self._file = file
        self._topics = Topics(header.layout)
        self._real_time = real_time
        self._side = side
        self._commit_s = commit_s
        self._notes: deque[Note | Sample | Checkpoint] = deque()
        self._look: Callable[[], EngineState | None] = lambda: None
        self._checkpoint_s: float | None = None
        self._made_s: float | None = None
        self._step = 0
        self._rows: dict[Topic, list[tuple[Any, ...]]] = defaultdict(list)
        self._since_s = 0.0
        self._steps = 0
        self._cut_s = perf_counter()
        self._making = threading.Lock()
        self._unwritten: deque[_Piece] = deque()
        self._wake = threading.Event()
        self._ending = False
        self._thread = threading.Thread(target=self._work, name="recorder", daemon=True)
        self._thread.start()

    # --- the run's side ---------------------------------------------------------------------

    def follow(self, look: Callable[[], EngineState | None]) -> None:
        """This shows the engine's state after the step that was noted last."""
        self._look = look

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        *,
        body: RobotState | None = None,
        paused: bool = False,
    ) -> None:
        """The start of the engine is noted, with what it was given."""
        self.begun = True
        for event in seen:
            self._note(Note(event, now_s, ()))
        self._note(Note(Started(paused, body_to_text(body)), now_s, effects))

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """One step of the engine is noted."""
        self._note(Note(event, now_s, effects))
        if self._checkpoint_s is None or now_s >= self._checkpoint_s:
            self._remember(now_s)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """What was done without the engine is noted."""
        self.begun = True
        self._note(Note(Abandoned(), now_s, effects))

    def close(self) -> None:
        """The recording is complete, or ``failure`` says why not."""
        self._ending = True
        self._wake.set()
        self._thread.join(_PATIENCE_S)
        if self._thread.is_alive():
            self._fail("the disk does not answer")

    def _note(self, note: Note) -> None:
        if self.failure:
            return
        self._notes.append(note)
        side = self._side
        if side is not None and note.at_s >= side.due_s:
            sample = side.look(note.at_s)
            if sample is not None:
                self._notes.append(sample)
        if len(self._notes) > (_MOST_NOTES if self._real_time else _HELP_AT):
            self._lend_a_hand()

    def _remember(self, now_s: float) -> None:
        """From the step that was noted last a reader can begin, except from the very first."""
        state = self._look() if self._checkpoint_s is not None else None
        self._checkpoint_s = now_s + CHECKPOINT_S
        if state is not None and not self.failure:
            self._notes.append(Checkpoint(now_s, state))

    def _lend_a_hand(self) -> None:
        """The notes are fewer, or the recording has ended."""
        if self._real_time or sum(len(each.data) for each in self._unwritten) > _MOST_BYTES:
            self._fail("the disk is too slow")
            return
        try:
            with self._making:
                self._make()
                if perf_counter() >= self._cut_s + self._commit_s * _EARLIER:
                    self._cut()
                    self._wake.set()
        except Exception as error:
            self._fail(_told(error))

    def _fail(self, why: str) -> None:
        self.failure = self.failure or why
        self._notes.clear()

    # --- the thread's side ------------------------------------------------------------------

    def _work(self) -> None:
        try:
            while not self._ending and not self.failure:
                self._wake.wait(max(0.0, self._cut_s + self._commit_s - perf_counter()))
                self._wake.clear()
                if perf_counter() >= self._cut_s + self._commit_s:
                    self._commit()
                else:  # the run itself has just seen to that
                    self._write()
            if not self.failure:
                self._commit()
                self._file.finish()
        except Exception as error:
            self._fail(_told(error))
        try:
            self._file.close()
        except OSError as error:
            self._fail(_told(error))

    def _commit(self) -> None:
        """Everything noted so far is in the file."""
        with self._making:
            self._make()
            self._cut()
        self._write()

    def _write(self) -> None:
        """Every piece that was cut is in the file."""
        while self._unwritten:
            piece = self._unwritten.popleft()
            self._file.write(piece.data)
            self.kept_s = piece.until_s

    # --- either side, one at a time -----------------------------------------------------------

    def _make(self) -> None:
        """The notes have become messages."""
        notes = self._notes
        for _ in range(len(notes)):
            try:
                note = notes.popleft()
            except IndexError:  # it has been given up meanwhile
                return
            if isinstance(note, Sample):
                self._show(note)
            elif isinstance(note, Checkpoint):
                self._keep(note)
            else:
                self._add(note)
        if self._steps >= _MOST_STEPS:
            self._cut()

    def _cut(self) -> None:
        """The messages so far are bytes that wait for the disk."""
        self._batch()
        self._steps, self._cut_s = 0, perf_counter()
        data = self._file.cut()
        if data:
            self._unwritten.append(_Piece(data, self._made_s))

    def _add(self, note: Note) -> None:
        if note.at_s >= self._since_s + _BATCH_S:
            self._batch()
            self._since_s = note.at_s
        step, at_s, rows, topics = self._step, note.at_s, self._rows, self._topics
        self._made_s = at_s
        self._step = step + 1
        self._steps += 1
        rows[topics.of_input(note.event)].append((step, at_s, note.event))
        for place, effect in enumerate(note.effects):
            row = (step, at_s, place, effect)
            rows[topics.of_effect(effect)].append(row)
        if note.effects and self._side is not None:
            self._side.tell(self._file, note.at_s, note.effects)

    def _keep(self, it: Checkpoint) -> None:
        row = (self._step - 1, it.at_s, Remembered(state_to_text(it.state)))
        self._rows[STATE].append(row)

    def _show(self, sample: Sample) -> None:
        if self._side is not None:
            self._side.show(self._file, sample)

    def _batch(self) -> None:
        """The rows gathered so far are messages of the coming commit."""
        for topic, rows in self._rows.items():
            data = topic.encode(rows)
            self._file.add(topic.name, rows[0][1], data, topic.schema, topic.schema_name)
        self._rows.clear()


def _told(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return f"{type(error).__name__}: {error}"
