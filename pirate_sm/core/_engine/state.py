"""The immutable state of the engine between two events."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import NamedTuple

from pirate_sm.core._engine.mission.program import HandlerSpec, Program
from pirate_sm.core._engine.records import often_replaced
from pirate_sm.core._engine.robot.command_outcome import refusal
from pirate_sm.core._engine.robot.declared_states import LOOKING, Look
from pirate_sm.core._engine.robot.evidence import Proofs
from pirate_sm.core._engine.robot.loops import Loops
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    STOPPED,
    Finished,
    Mark,
    RobotState,
    obeyed,
    states_of,
)
from pirate_sm.core._engine.sensing.environment import Surveyed
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core.effects import Outcome

Words = tuple[str | None, ...]

OUTSIDE = ("detector", "segment", "joint")
"""Names of the last words of a state, which come from outside or from the surroundings."""


class Ending(NamedTuple):
    """The run is ending: the safe array has been sent.

    Attributes:
        give_up_s: When the run ends even without a result of the array.
    """

    outcome: Outcome
    message: str
    end: str
    give_up_s: float


class BeforePause(NamedTuple):
    """The actuation in force when a pause began, to be restored afterwards.

    Attributes:
        values: Setpoints; NaN where nothing is restored.
        suspended: Whether a command was under way, which continues after the pause.
        doubts: Marks that exist only because the pause has stopped the wheels.
    """

    values: tuple[float, ...]
    loops: Loops
    configuration: int
    suspended: bool
    doubts: frozenset[Mark] = frozenset()


class Counted(NamedTuple):
    """A distance, from which later ones count.

    Attributes:
        width_m: How far the robot could be from the odometry then, where all wheels had reported.
        late_m: How far it could have driven since they should have.
        rolled_m: How far it had driven, back and forth.
    """

    odometry_m: float = 0.0
    width_m: float = 0.0
    rolled_m: float = 0.0
    late_m: float = 0.0


@often_replaced
class MissionState(NamedTuple):
    """The progress of the mission.

    Attributes:
        pc: Index of the current instruction.
        begun: Whether it has begun: its command is given, its wait armed or its question asked.
        tries: How often its command has been repeated.
        armed_s: Mission time at which it began.
        since: Per trigger the mission time at which its condition became true, NaN while it is not.
            For a command or a requirement: when it began to wait for sight of a clamp.
        origin: Signals from which the last wait counts that uses their changes; empty before it.
        counts_from: The distance when the origin was taken.
        claim: From where the distance counts by which the mission has come here; None without one.
        result: How its command ended, once it has.
        answer: The operator's answer in this step; ``skipped``: the trigger to skip to.
        cause: Reason of the last failure or fault.
        handling: Phase that handles a fault; empty without one.
        diverting: Handler that starts once the wheels are stopped; ``stopped``: they are.
        offset_s: Total duration of the pauses so far.
        paused_s: When the present pause began, NaN while running.
        pause_wanted: Whether the mission pauses as soon as no array is awaited.
        one_step: Whether the mission pauses again after this instruction.
        breakpoints: Places of the instructions before which it pauses.
        until: Another one, before which it pauses once; empty for none.
        passes: Whether its current instruction begins in spite of a breakpoint, because the
            operator has resumed the mission there.
        sight_until_s: Until when it pauses for sensors to show again that a part holds; infinite
            if it does not.
        second_s: Mission time at which the second began in which ``entered`` counts phases.
    """

    pc: int
    begun: bool = False
    tries: int = 0
    armed_s: float = 0.0
    since: tuple[float, ...] = ()
    origin: tuple[float, ...] = ()
    counts_from: Counted = Counted()
    claim: Counted | None = None
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
    breakpoints: tuple[str, ...] = ()
    until: str = ""
    passes: bool = False
    sight_until_s: float = inf
    before_pause: BeforePause | None = None
    ending: Ending | None = None
    ended: bool = False
    second_s: float = -inf
    entered: int = 0

    @property
    def paused(self) -> bool:
        """Return whether the mission is paused: by the operator, or until its robot is known."""
        return not isnan(self.paused_s)

    def clock(self, now: float) -> float:
        """Return the mission time, which does not advance during a pause."""
        return (self.paused_s if self.paused else now) - self.offset_s

    @property
    def suspended(self) -> bool:
        """Return whether a pause has suspended a command."""
        return self.before_pause is not None and self.before_pause.suspended

    def motion_clock(self, now: float) -> float:
        """Return the time of the command under way; it does not advance while suspended."""
        return self.paused_s if self.suspended else now

    def at(self, pc: int) -> MissionState:
        """Return the mission at the start of the instruction at ``pc``."""
        return self._replace(
            pc=pc,
            begun=False,
            tries=0,
            since=(),
            result=None,
            answer=None,
            skipped=None,
            passes=False,
        )


class FaultState(NamedTuple):
    """The state of the fault rules: since when each holds, and which have been raised.

    Attributes:
        since: Per rule when its condition became true, NaN while it is not.
        raised: Rules that were raised and still hold.
        silent: Boards reported as silent; ``blind``: numbers reported as without value.
        listening_s: Since when the share of lost reports is counted.
    """

    since: tuple[float, ...]
    raised: frozenset[int] = frozenset()
    silent: frozenset[int] = frozenset()
    blind: frozenset[int] = frozenset()
    listening_s: float = 0.0


@often_replaced
class EngineState(NamedTuple):
    """Everything the engine remembers.

    Attributes:
        words: State of each region, then the words of ``OUTSIDE``; None is unknown.
        word_until_s: End of the validity of the detector's word.
        wake_at_s: The next time at which something changes without an event.
        look: The running start check, None after it; no command begins during it.
        rules: Progress of each safety rule, see :mod:`pirate_sm.core._engine.safety`.
        surveyed: The pipe around the robot.
        lapsed: The running comparison for parts whose sensors were not known; None without any.
        proofs: What has shown each state and clamp.
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
    lapsed: Look | None = None
    proofs: Proofs = ()

    @property
    def looking(self) -> Look | None:
        """Return the running start check; None while an array is awaited that holds the robot."""
        return self.look if self.robot.awaited is None else None

    def moved(self, robot: RobotSpec, body: RobotState) -> EngineState:
        """Return the state with this robot state, and with the words of its configuration."""
        if body.configuration == self.robot.configuration:
            return self._replace(robot=body)
        return self._replace(
            robot=body, words=(*states_of(robot, body), *self.words[-len(OUTSIDE) :])
        )

    def outside(self, name: str) -> str | None:
        """Return one of the words of ``OUTSIDE``; None if it is unknown."""
        return self.words[OUTSIDE.index(name) - len(OUTSIDE)]

    def hearing(self, **changed: str | None) -> EngineState:
        """Return the state with other words of ``OUTSIDE``, given by name."""
        known = zip(OUTSIDE, self.words[-len(OUTSIDE) :], strict=True)
        words = [changed.get(name, word) for name, word in known]
        return self._replace(words=(*self.words[: -len(OUTSIDE)], *words))

    def finished(self, command: Finished | None) -> EngineState:
        """Return the state with the result of the mission's command.

        Results during a pause belong to commands of the operator and are ignored.
        """
        if command is None or self.mission.paused:
            return self
        return self._replace(mission=self.mission._replace(result=command))

    def obeyed_words(self, robot: RobotSpec) -> Words:
        """Return the words for fault rules; None for regions that a pause or fault has stopped."""
        if self.mission.before_pause is None:
            marks = self.robot.marks  # usually empty: return early
            if not marks or all(mark.command != STOPPED for mark in marks):
                return self.words
        return (*obeyed(robot, self.robot), *self.words[-len(OUTSIDE) :])

    def why_not_command(self, robot: RobotSpec, index: int, *, at_once: bool = False) -> str:
        """Return why a command of the operator would be refused now; empty if it would be accepted.

        Args:
            robot: The robot.
            index: The command, as an index into the chart's commands.
            at_once: Whether it ends a drive that is under way, as in ``OperatorCommand``.
        """
        mission, body = self.mission, self.robot
        if mission.ended or mission.ending is not None:
            return "impossible: the mission is ending"
        if self.look is not None:
            return f"impossible: {LOOKING}"
        motion, stops = body.motion, robot.commands[index].done.kind == "stopped"
        if motion is not None and not mission.suspended:
            drives = bool(robot.driven[motion.target])
            if not (at_once and stops and drives) or motion.place:
                return "impossible: another command is under way"
        if body.awaited is not None:
            return "impossible: setpoints are in flight"
        return refusal(robot, body, index)

    def why_not_resume(self) -> str:
        """Return why a paused mission cannot resume where it was; empty if it can, or runs."""
        before, body = self.mission.before_pause, self.robot
        if before is None:
            return ""
        if self.look is not None and self.look.before is not None:
            return LOOKING
        if body.awaited:
            return "setpoints are in flight"
        if body.configuration != before.configuration:
            return "the configuration has been changed"
        if body.motion is not None and not before.suspended:
            return "a command is under way"
        return ""

    def why_not_go_to(self, program: Program, phase: str) -> str:
        """Return why the mission cannot resume at this phase now; empty if it can."""
        if program.enter(phase) is None:
            return "the mission has no such phase"
        if not self.mission.paused:
            return "pause the mission first"
        if self.look is not None:
            return LOOKING
        if self.robot.awaited is not None:
            return "setpoints are in flight"
        if self.robot.motion is not None and not self.mission.suspended:
            return "a command is under way"
        return ""
