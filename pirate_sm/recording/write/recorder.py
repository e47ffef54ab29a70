"""Records a run while it goes on: the run itself only notes what happened.

A thread encodes the notes and waits for the disk, so that neither slows the loop down. An error
there ends the recording, not the run; ``failure`` gives the reason.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from time import perf_counter

from pirate_sm.engine.robot.robot_state import RobotState
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect
from pirate_sm.model.events import Event
from pirate_sm.recording.format.engine_topics import Abandoned, Started, Topics
from pirate_sm.recording.format.header import RunHeader
from pirate_sm.recording.format.robot_state_text import body_to_text
from pirate_sm.recording.write.piece_maker import PieceMaker, StateNote, StepNote, WrittenPiece
from pirate_sm.recording.write.recording_file import RecordingFile
from pirate_sm.recording.write.side_channel import Sample, SideChannel

COMMIT_S = 0.25
"""Interval at which notes are written to disk, s; the documentation promises half a second."""

CHECKPOINT_S = 60.0
"""The longest mission time between two checkpoints, from which reading can begin, s."""

_EARLIER = 0.8
"""A run that encodes notes itself cuts them after this share of the time between commits."""

_MOST_STEPS = 20_000
"""The most steps in one commit."""

_HELP_AT = 2_000
"""A run without a robot encodes notes itself when more than this many wait."""

_MOST_NOTES = 200_000
"""The most notes that may wait for the thread while a robot is connected."""

_MOST_BYTES = 1 << 28
"""The most bytes that may wait for the disk."""

_PATIENCE_S = 20.0
"""How long the end of a run waits for the disk, s."""


class Recorder:
    """Records every input and effect of the engine.

    Args:
        file: The file.
        header: Its header.
        real_time: Whether a robot waits for the run. If none does, the run helps to encode when it
            is faster than the thread, because two threads of one interpreter hinder each other.
        side: Makes the messages for viewers.
        commit_s: Interval of the wall clock at which everything is written to disk.

    Attributes:
        failure: Why recording has stopped; empty if it has not.
        kept_s: Mission time up to which everything is in the file; None before the first commit.
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
        self._pieces = PieceMaker(file, Topics(header.layout), side)
        self._real_time = real_time
        self._side = side
        self._commit_s = commit_s
        self._notes: deque[StepNote | Sample | StateNote] = deque()
        self._look: Callable[[], EngineState | None] = lambda: None
        self._checkpoint_s: float | None = None
        self._cut_s = perf_counter()
        self._making = threading.Lock()
        self._unwritten: deque[WrittenPiece] = deque()
        self._wake = threading.Event()
        self._ending = False
        self._thread = threading.Thread(target=self._work, name="recorder", daemon=True)
        self._thread.start()

    # --- the run's side ---------------------------------------------------------------------

    def follow(self, look: Callable[[], EngineState | None]) -> None:
        """Set the function that returns the engine's state after the last noted step."""
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
        """Note the start of the engine, with its inputs."""
        self.begun = True
        for event in seen:
            self._note(StepNote(event, now_s, ()))
        self._note(StepNote(Started(paused, body_to_text(body)), now_s, effects))

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Note one step of the engine."""
        self._note(StepNote(event, now_s, effects))
        if self._checkpoint_s is None or now_s >= self._checkpoint_s:
            self._remember(now_s)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Note effects of actions past the engine."""
        self.begun = True
        self._note(StepNote(Abandoned(), now_s, effects))

    def close(self) -> None:
        """Write the rest and close the file; if that fails, ``failure`` gives the reason."""
        self._ending = True
        self._wake.set()
        self._thread.join(_PATIENCE_S)
        if self._thread.is_alive():
            self._fail("the disk does not answer")

    def _note(self, note: StepNote) -> None:
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
        """Note the engine's state when a checkpoint is due, except after the first step."""
        state = self._look() if self._checkpoint_s is not None else None
        self._checkpoint_s = now_s + CHECKPOINT_S
        if state is not None and not self.failure:
            self._notes.append(StateNote(now_s, state))

    def _lend_a_hand(self) -> None:
        """Encode notes in the run itself, or end a recording that is too slow."""
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
            self._fail(_reason(error))

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
                else:  # the run itself has just written
                    self._write()
            if not self.failure:
                self._commit()
                self._file.finish()
        except Exception as error:
            self._fail(_reason(error))
        try:
            self._file.close()
        except OSError as error:
            self._fail(_reason(error))

    def _commit(self) -> None:
        """Write everything noted so far to the file."""
        with self._making:
            self._make()
            self._cut()
        self._write()

    def _write(self) -> None:
        """Write every piece that was cut to the file."""
        while self._unwritten:
            piece = self._unwritten.popleft()
            self._file.write(piece.data)
            self.kept_s = piece.until_s

    # --- either side, one at a time -----------------------------------------------------------

    def _make(self) -> None:
        """Make messages of the notes."""
        notes = self._notes
        for _ in range(len(notes)):
            try:
                note = notes.popleft()
            except IndexError:  # the recording has ended meanwhile
                return
            self._pieces.take(note)
        if self._pieces.steps >= _MOST_STEPS:
            self._cut()

    def _cut(self) -> None:
        """Encode the messages so far as a piece, which waits for the disk."""
        self._cut_s = perf_counter()
        piece = self._pieces.cut()
        if piece.data:
            self._unwritten.append(piece)


def _reason(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return f"{type(error).__name__}: {error}"
