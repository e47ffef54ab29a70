"""How near a run came to a fault or a limit.

Each near miss has a share of its limit: at 1 it would have happened, so the largest are nearest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, isinf

from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event
from pirate_sm.core.program import Program
from pirate_sm.core.resuming import AS_DECLARED, Beginning
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Glide
from pirate_sm.running.runtime.near_miss_kinds import (
    CommandTimes,
    EngineStep,
    FaultMargins,
    NearMiss,
    TriggerTimes,
    WaitTimes,
    WordTimes,
)


class NearMisses:
    """A tap that keeps the nearest miss of each kind.

    Args:
        robot: The robot with the fault rules.
        program: The mission with the limits.
    """

    stepwise = True
    due_s = -inf

    def __init__(self, robot: RobotSpec, program: Program) -> None:
        self._robot = robot
        self._program = program
        self._state: Callable[[], EngineState | None] = lambda: None
        self._calls: dict[str, NearMiss] = {}
        self._over = False  # the safe stop does not count
        missions = CommandTimes(program), WaitTimes(), TriggerTimes(program)
        self._notes = (*missions, WordTimes(robot, program), FaultMargins(robot))

    def follow(self, state: Callable[[], EngineState | None]) -> None:
        """Read the engine's state from here; it is None before the engine has started."""
        self._state = state

    def nearest(self) -> list[NearMiss]:
        """Return the nearest miss of each kind, the nearest first."""
        return sorted(self._calls.values(), key=lambda call: -call.share)

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Look at the start of the run."""
        self._look(None, now_s, effects)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Look at a step."""
        self._look(event, now_s, effects)

    def secure(self) -> None:
        """Do nothing: what it notes lives no longer than this program."""

    def take_glide(self, glide: Glide) -> None:
        """Look at each step of a glide."""
        for now_s, event, effects in glide.in_order():
            self.take(event, now_s, effects)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Do nothing: actions past the engine do not count."""

    def _look(self, event: Event | None, now_s: float, effects: Sequence[Effect]) -> None:
        state = self._state()
        if state is None or self._over:
            return
        self._over = state.mission.ending is not None or state.mission.ended
        moment = EngineStep(state, event, now_s, effects)
        for each in self._notes:
            for call in each.look(moment):
                self._note(call)
        self._limit(now_s)

    def _limit(self, now_s: float) -> None:
        limit_s = self._program.time_limit_s
        if not isinf(limit_s):
            text = f"the mission took {now_s:.1f} s of its time limit of {limit_s:g} s"
            self._note(NearMiss("time limit", text, now_s / limit_s, now_s))

    def _note(self, call: NearMiss) -> None:
        before = self._calls.get(call.about)
        if before is None or call.share > before.share:
            self._calls[call.about] = call
