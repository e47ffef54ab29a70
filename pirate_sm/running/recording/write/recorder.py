"""Records a run while it is under way: the run itself only notes what happened.

A thread encodes the notes and waits for the disk, so that neither slows the loop down. An error
there ends the recording, not the run; ``failure`` gives the reason.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from math import inf
from time import perf_counter

from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, Trail
from pirate_sm.core.resuming import AS_DECLARED, Beginning
from pirate_sm.core.sensing import Glide
from pirate_sm.running.recording.format.engine_topics import Abandoned, Input, Started, Topics
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.format.json_values import body_to_text, resumption_to_text
from pirate_sm.running.recording.write.piece_maker import Gathered, PieceMaker, Told, WrittenPiece
from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.recording.write.sampler import KeptSamples, SideChannel

AHEAD_S = 0.010
"""The longest time that a command waits for the disk, s: a third of a round of the boards [D]."""

COMMIT_S = 0.25
"""Interval at which notes are written to disk, s; the documentation promises half a second."""

CHECKPOINT_S = 60.0
"""The longest mission time between two checkpoints, from which reading can begin, s."""

PIECE_S = 2.0
"""The longest mission time in one piece, s: a wrong bit costs no more. A robot's are shorter."""

_EARLIER = 0.8
"""A run that encodes notes itself cuts them after this share of the time between commits."""

_MOST_STEPS = 20_000
"""The most steps in one commit."""

_HELP_AT = 20_000
"""A run without a robot encodes its steps itself when more than this many wait."""

_MOST_WAITING = 200_000
"""The most steps that may wait for the thread while a robot is connected."""

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
        side: Makes the messages for viewers, or keeps the samples that they can be made from.
        commit_s: Interval of the wall clock at which everything is written to disk.

    Attributes:
        failure: Why recording has stopped; empty if it has not.
        kept_s: Mission time up to which everything is in the file; None before the first commit.
        begun: Whether anything has been noted.
        stepwise: Whether it looks at the run after each step: for messages for viewers.
        ahead_s: The longest time that :meth:`secure` waits for the disk.
    """

    def __init__(
        self,
        file: RecordingFile,
        header: RunHeader,
        *,
        real_time: bool,
        side: SideChannel | KeptSamples | None = None,
        commit_s: float = COMMIT_S,
    ) -> None:
        self.failure = ""
        self.kept_s: float | None = None
        self.begun = False
        self.ahead_s = AHEAD_S
        self.stepwise = isinstance(side, SideChannel)
        self._file = file
        topics = Topics(header.layout)
        self._pieces = PieceMaker(file, topics, side)
        self._gathered = Gathered(0, topics.channels)
        self._gathering = threading.Lock()
        self._real_time = real_time
        self._due_s = -inf
        self._side = side
        self._commit_s = commit_s
        self._hand_over()
        self._look: Callable[[], EngineState | None] = lambda: None
        self._checkpoint_s = -inf
        self._piece_s = inf if real_time else -inf
        self._trail: Trail | None = None
        self._cut_s = perf_counter()
        self._urgent = False
        self._written = threading.Condition()
        self._written_step = 0
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
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Note the start of the engine, with its inputs."""
        self.begun = True
        for event in seen:
            self._note(event, now_s, ())
        body, resumed = body_to_text(begins.body), resumption_to_text(begins.resumed)
        self._note(Started(begins.paused, body, resumed), now_s, effects)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Note one step of the engine."""
        with self._gathering:
            step = self._gathered.add(event, now_s, effects)
        if now_s >= self._due_s or step >= self._full:
            self._attend(now_s)

    def secure(self) -> None:
        """Return when everything noted so far is on the disk, but after ``ahead_s`` at the latest.

        If it is not there by then, the recording says so.
        """
        if self.failure:
            return
        step, began_s = self._gathered.step, perf_counter()
        self._urgent = True
        self._wake.set()
        with self._written:
            if self._written.wait_for(lambda: self._written_step >= step, self.ahead_s):
                return
        waited_s = perf_counter() - began_s
        with self._gathering:
            self._gathered.unlogged.append((step - 1, self._gathered.until_s or 0.0, waited_s))

    def take_glide(self, glide: Glide) -> None:
        """Note the steps of the engine that were taken together."""
        side, self._trail = self._side, glide.trail
        with self._gathering:
            step = self._gathered.add_glide(glide)
            until_s = self._gathered.until_s
        if until_s is None:
            return
        if side is not None and glide.trail is not None and until_s >= side.due_s:
            self._keep(side.look_back(glide.times_s(), glide.trail))
        if until_s >= self._due_s or step >= self._full:
            self._attend(until_s)

    @property
    def due_s(self) -> float:
        """Return when it looks at the engine next."""
        follows = self._side is None or self._side.follows_trails
        return min(self._checkpoint_s, self._piece_s) if follows else self._due_s

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Note effects of actions past the engine."""
        self.begun = True
        self._note(Abandoned(), now_s, effects)

    def close(self) -> None:
        """Write the rest and close the file; if that fails, ``failure`` gives the reason."""
        self._ending = True
        self._wake.set()
        self._thread.join(_PATIENCE_S)
        if self._thread.is_alive():
            self._fail("the disk does not answer")

    def _note(self, event: Input, now_s: float, effects: Sequence[Effect]) -> None:
        with self._gathering:
            self._gathered.add(event, now_s, effects)
        if self._side is not None and now_s >= self._side.due_s:
            self._sample(self._side, now_s)

    def _attend(self, now_s: float) -> None:
        """Do what is due after a step: a sample, a checkpoint, help for the thread."""
        side = self._side
        if self.failure:
            self._hand_over()
            return
        if side is not None and now_s >= side.due_s:
            self._sample(side, now_s)
        if now_s >= self._checkpoint_s:
            self._remember(now_s)
        ends = now_s >= self._piece_s > -inf
        if now_s >= self._piece_s:
            self._piece_s = now_s + PIECE_S
        self._due_s = min(self._checkpoint_s, self._piece_s, inf if side is None else side.due_s)
        if ends or self._gathered.step >= self._full:
            self._lend_a_hand(ends=ends)

    def _sample(self, side: SideChannel | KeptSamples, now_s: float) -> None:
        self._keep(side.look(now_s, None if self._trail is None else self._trail.at(now_s)))

    def _keep(self, sample: Told | None) -> None:
        if sample is not None:
            with self._gathering:
                self._gathered.told.append(sample)

    def _remember(self, now_s: float) -> None:
        """Note the engine's state when a checkpoint is due, except after the first step."""
        state = self._look() if self._checkpoint_s > -inf else None
        self._checkpoint_s = now_s + CHECKPOINT_S
        if state is not None:
            with self._gathering:
                self._gathered.remember(now_s, state)

    def _lend_a_hand(self, *, ends: bool) -> None:
        """Encode the steps in the run itself, or end a recording that is too slow.

        Args:
            ends: Whether a piece ends here.
        """
        waiting = self._unwritten.copy()  # the thread takes pieces from it meanwhile
        if self._real_time or sum(len(each.data) for each in waiting) > _MOST_BYTES:
            self._fail("the disk is too slow")
            return
        try:
            with self._making:
                self._make()
                if ends or perf_counter() >= self._cut_s + self._commit_s * _EARLIER:
                    self._cut()
                    self._wake.set()
        except Exception as error:
            self._fail(_reason(error))

    def _fail(self, why: str) -> None:
        self.failure = self.failure or why
        self._hand_over()

    # --- the thread's side ------------------------------------------------------------------

    def _work(self) -> None:
        try:
            while not self._ending and not self.failure:
                self._wake.wait(max(0.0, self._cut_s + self._commit_s - perf_counter()))
                self._wake.clear()
                if self._urgent or perf_counter() >= self._cut_s + self._commit_s:
                    self._urgent = False
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
            with self._written:
                self._written_step = piece.step
                self._written.notify_all()

    # --- either side, one at a time -----------------------------------------------------------

    def _make(self) -> None:
        """Make messages of what was noted."""
        self._pieces.take(self._hand_over())
        if self._pieces.steps >= _MOST_STEPS:
            self._cut()

    def _hand_over(self) -> Gathered:
        """Return what was noted since the last call."""
        with self._gathering:
            noted = self._gathered
            self._gathered = noted.next()
            self._full = noted.step + (_MOST_WAITING if self._real_time else _HELP_AT)
        return noted

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
