"""What the engine remembers between two events; all of it immutable."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import NamedTuple

from pirate_sm.engine.control.loops import Loops
from pirate_sm.engine.mission.program import HandlerSpec
from pirate_sm.engine.records import often_replaced
from pirate_sm.engine.robot.confirmation import Look
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    STOPPED,
    Finished,
    Mark,
    RobotState,
    obeyed,
    states_of,
)
from pirate_sm.engine.sensing.environment import Surveyed
from pirate_sm.engine.sensing.known_signals import Sensing
from pirate_sm.model.effects import Outcome

Words = tuple[str | None, ...]


class Ending(NamedTuple):
    """The run is ending: the safe array has been sent.

    Attributes:
        give_up_s: When it ends even though the array's fate is not known.
    """

    outcome: Outcome
    message: str
    end: str
    give_up_s: float


class BeforePause(NamedTuple):
    """What was in force when a pause began, to be asserted again.

    Attributes:
        values: Setpoints; NaN where nothing is to be asserted.
        suspended: Whether a command was under way and goes on after the pause.
        doubts: What is unconfirmed only because the pause has stopped the wheels.
    """

    values: tuple[float, ...]
    loops: Loops
    configuration: int
    suspended: bool
    doubts: frozenset[Mark] = frozenset()


@often_replaced
class MissionState(NamedTuple):
    """Where the mission is.

    Attributes:
        pc: Index of the current instruction.
        begun: Whether it has begun: its command is given, its wait armed, its question asked.
        tries: How often its command has been tried again.
        armed_s: Mission time at which it began.
        since: Per trigger the mission time since which its condition has been true, else NaN.
        origin: Signals at that time, where a wait compares later ones with them; else empty.
        result: How its command ended, once it has.
        answer: What the operator has just answered; ``skipped`` what he has just passed over.
        cause: Why the last failure or fault happened.
        handling: Phase that handles a fault; empty when none does.
        diverting: Where a fault leads once the wheels are stopped; ``stopped`` when they are.
        offset_s: How long the mission has been paused in all.
        paused_s: When the present pause began, NaN while running.
        pause_wanted: Whether it shall pause as soon as no array is awaited.
        one_step: Whether it shall pause again after this instruction.
        second_s: Mission time from which on ``entered`` counts phases, for one second.
    """

    pc: int
    begun: bool = False
    tries: int = 0
    armed_s: float = 0.0
    since: tuple[float, ...] = ()
    origin: tuple[float, ...] = ()
    result: Finished | None = None
    answer: str | None = None
    skipped: str | None = None
    cause: str = ""
    handling: str = ""
    diverting: HandlerSpec | None = None
    stopped: bool = False
    offset_s: float = 0.0
    paused_s: float = nan
    pause_wanted: bool = False
    one_step: bool = False
    before_pause: BeforePause | None = None
    ending: Ending | None = None
    ended: bool = False
    second_s: float = -inf
    entered: int = 0

    @property
    def paused(self) -> bool:
        """Whether the mission stands still by the operator's wish."""
        return not isnan(self.paused_s)

    def clock(self, now: float) -> float:
        """Return the mission time, which stands still during a pause."""
        return (self.paused_s if self.paused else now) - self.offset_s

    @property
    def suspended(self) -> bool:
        """Whether a command is under way that the pause has suspended."""
        return self.before_pause is not None and self.before_pause.suspended

    def motion_clock(self, now: float) -> float:
        """Return the time as the command under way counts it: it stands still while suspended."""
        return self.paused_s if self.suspended else now

    def at(self, pc: int) -> MissionState:
        """Return the mission before its instruction at ``pc``."""
        return self._replace(
            pc=pc, begun=False, tries=0, since=(), origin=(), result=None, answer=None, skipped=None
        )


class FaultState(NamedTuple):
    """Which fault rules hold, since when, and which have been raised.

    Attributes:
        since: Per rule, NaN while its condition does not hold.
        raised: Rules raised and not yet untrue again.
        silent: Boards reported as silent; ``blind``: numbers reported as having no value.
    """

    since: tuple[float, ...]
    raised: frozenset[int] = frozenset()
    silent: frozenset[int] = frozenset()
    blind: frozenset[int] = frozenset()


@often_replaced
class EngineState(NamedTuple):
    """Everything the engine remembers.

    Attributes:
        words: State of each region, then the detector's word and the segment; None is unknown.
        word_until_s: Until when the detector's word is valid.
        wake_at_s: When time alone will change something.
        look: While the sensors are compared with what is declared; nothing is commanded then.
        rules: Where each safety rule of the program is, see :mod:`pirate_sm.engine.safety.rules`.
        surveyed: The pipe around the robot.
    """

    robot: RobotState
    sensing: Sensing
    mission: MissionState
    faults: FaultState
    words: Words
    word_until_s: float = inf
    wake_at_s: float = inf
    rules: tuple[int, ...] = ()
    surveyed: Surveyed = Surveyed()
    look: Look | None = None

    def moved(self, robot: RobotSpec, body: RobotState) -> EngineState:
        """Return the state with the robot as it is now; the words say its configuration."""
        if body.configuration == self.robot.configuration:
            return self._replace(robot=body)
        return self._replace(robot=body, words=(*states_of(robot, body), *self.words[-2:]))

    def finished(self, command: Finished | None) -> EngineState:
        """Return the state in which the mission knows how its command ended.

        During a pause commands are the operator's.
        """
        if command is None or self.mission.paused:
            return self
        return self._replace(mission=self.mission._replace(result=command))

    def obeyed_words(self, robot: RobotSpec) -> Words:
        """Return what rules for faults see: wheels stopped by a pause or a fault are not stuck."""
        if self.mission.before_pause is None:
            marks = self.robot.marks  # mostly none: do not begin to look
            if not marks or all(mark.command != STOPPED for mark in marks):
                return self.words
        return (*obeyed(robot, self.robot), *self.words[-2:])
