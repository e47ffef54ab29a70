"""Passes snapshots from the run's thread to the console, and events back."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from math import inf, isnan

from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Answer, Event
from pirate_sm.running.runtime.loop import Clock, MissionRun
from pirate_sm.running.runtime.scripted_events import Answered
from pirate_sm.running.wiring import Prepared
from pirate_sm.views.showing.effect_lines import EffectLine
from pirate_sm.views.showing.live_snapshots import Trends, snapshot_of
from pirate_sm.views.showing.run_history import Memory
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot

QUIET = frozenset({"another mission was chosen", "the console was left"})
"""Ends that the operator has requested by other means than a stop; they need no banner."""

HELD_S = 1.0
"""After this long without a new snapshot the newest one is not taken for the present any more."""

LOOK_EVERY_S = 0.02
"""The longest delay of an operator's event to the engine."""


class RunBridge:
    """An observer, watcher and companion of the runs of one session, one after the other.

    Attributes:
        asked: Number of the operator's events in the present run.
    """

    listening = False

    def __init__(self, scene: MissionScene, prepared: Prepared, clock: Clock) -> None:
        self._clock = clock
        self._scene = scene
        self._prepared = prepared
        self._memory = Memory(scene.robot, nominal=scene.engine.nominal, quiet=QUIET)
        self._waiting: deque[Event] = deque()
        self._run: MissionRun | None = None
        self._due_s = 0.0
        self._trends = Trends()
        self._over = False
        self._before_m = 0.0
        self.asked = 0
        self._newest = self._snapshot(0.0)
        self._made_s = clock.now()

    # --- from the console's thread ------------------------------------------------------------

    @property
    def latest(self) -> Snapshot:
        """The newest snapshot; it says how old it is if the run does not make newer ones."""
        newest, held_s = self._newest, self._clock.now() - self._made_s
        if newest.over or newest.state is None or held_s < HELD_S:
            return newest
        return replace(newest, held_s=held_s)

    def queue(self, event: Event) -> None:
        """Queue an event for the engine at the next turn of the loop."""
        self._waiting.append(event)

    # --- from the run's thread ----------------------------------------------------------------

    def begin(self, scene: MissionScene, prepared: Prepared, run: MissionRun) -> None:
        """Follow another run; the log keeps its earlier lines."""
        self._waiting.clear()
        came_m = self._snapshot(self.latest.now_s).odometry_m
        self._before_m += 0.0 if isnan(came_m) else came_m
        same = scene.loaded.documents == self._scene.loaded.documents
        self._memory.begin(scene.robot, same_mission=same)
        self._scene, self._prepared, self._run = scene, prepared, run
        self._due_s, self.asked = -inf, 0
        for notice in prepared.notices:
            self._memory.tell(EffectLine("console", notice), self.latest.now_s)

    def end(self, now_s: float) -> None:
        """Note that the last run is over."""
        self._over = True
        self._renew(now_s)

    @property
    def due_s(self) -> float:
        """When it is due: at once after a request of the operator."""
        return -inf if self._waiting else self._due_s

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing: :meth:`see` notes what has happened."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Make a new snapshot; return a log line for each answer of the operator."""
        self._due_s = now_s + LOOK_EVERY_S
        self._trends.look(self._scene, state, now_s)
        self._renew(now_s)
        return [
            Answered("info", f"answered '{event.choice}' (operator)")
            for event in tuple(self._waiting)
            if isinstance(event, Answer)
        ]

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the operator's events."""
        said = []
        while self._waiting:
            said.append(self._waiting.popleft())
        self.asked += len(said)
        return said

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note the effects for the log and the history of the run."""
        self._memory.see(effects, now_s)

    def pulse(self, now_s: float) -> None:
        """Make a new snapshot, also while mission time stands still."""
        self._renew(now_s)

    def _renew(self, now_s: float) -> None:
        self._newest, self._made_s = self._snapshot(now_s), self._clock.now()

    def _snapshot(self, now_s: float) -> Snapshot:
        state = self._run.state if self._run is not None else None
        what = self._scene, self._prepared, state, now_s, self._memory.story, self._trends
        return snapshot_of(*what, over=self._over, before_m=self._before_m)
