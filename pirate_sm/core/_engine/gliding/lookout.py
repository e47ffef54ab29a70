"""Find what must stay true so that frames change nothing but signals.

Each condition here stands for a part of :meth:`pirate_sm.core._engine.engine.Engine.step` that
would do something if it changed. Where a part has no such condition, nothing is watched, and every
frame goes through the engine.
"""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.core._engine.control.position_loop import RunningPositionLoop
from pirate_sm.core._engine.gliding.command_watch import command_conditions, same_duties
from pirate_sm.core._engine.gliding.conditions import codes_of
from pirate_sm.core._engine.gliding.watch import Condition, Watch
from pirate_sm.core._engine.mission.program import Do, Program, Question, SwitchControl, Wait
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.sensing.environment import Surveyed, announced, held_parts
from pirate_sm.core._engine.sensing.joint_around import joint_around
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState, MissionState
from pirate_sm.core._engine.waking import deadline_s, listening_s


class Lookout:
    """Tells what must stay true, for one engine.

    What it has found is remembered, because most of it stays the same for long.

    Args:
        robot: The robot.
        program: The mission.
    """

    def __init__(self, robot: RobotSpec, program: Program) -> None:
        self._robot = robot
        self._program = program
        self._codes = codes_of(robot)
        self._moment = Moment(robot, program, nominal=False, now_s=0.0)
        self._last: tuple[EngineState, Watch, float] | None = None

    def watch(self, state: EngineState) -> Watch | None:
        """Return what must stay true; None where every frame must go through the engine."""
        if not (_calm(state) and _sensors_are_calm(self._robot, state.sensing)):
            return None
        if self._judges(state):
            return None
        if self._last is None or not _same(self._last[0], state):
            if not (_runs(state.mission) and _is_covered(state.robot)):
                return None
            if not self._waits(state.mission, state.robot):
                return None
            found = self._conditions(state)
            if found is None:
                return None
            self._last = state, found, deadline_s(self._moment, state)
        _, watch, deadline = self._last
        robot, surveyed, word = self._robot, state.surveyed, state.outside("detector")
        settled = _is_settled(robot, surveyed, word)
        alarm, listening = min(deadline, state.word_until_s), listening_s(robot, state.sensing)
        if not settled or state.wake_at_s != min(alarm, listening):
            # The engine must survey, or has not been told yet when it will be called.
            alarm, listening = min(alarm, state.wake_at_s), inf
        survey_s = inf if settled else surveyed.due_s
        judged_s = state.sensing.distance.due_s if state.sensing.distance.running else inf
        return watch._replace(
            sensing=state.sensing,
            surveyed=surveyed,
            in_bend=announced(robot, surveyed, word),
            frames_until_s=min(watch.frames_until_s, survey_s, judged_s),
            wake_s=state.wake_at_s,
            deadline_s=deadline,
            word=word,
            word_until_s=state.word_until_s,
            alarm_s=alarm,
            listening_s=listening,
        )

    def _judges(self, state: EngineState) -> bool:
        """Return whether odometry is judged with each frame, or begins to be."""
        memory, latest = state.sensing.distance, state.robot.latest
        if memory.out or memory.running:
            return bool(memory.out) or memory.every_s < self._robot.link.period_s
        return memory.every_s > 0 and any(latest[wheel.slot] for wheel in self._robot.wheels)

    def _waits(self, mission: MissionState, body: RobotState) -> bool:
        """Return whether the mission waits for something that a frame brings, or for time."""
        if mission.paused:
            return True
        it = self._program.instructions[mission.pc]
        pending = body.awaited is not None or body.motion is not None
        match it:
            case Wait() | Question():
                return mission.begun
            case Do():
                return mission.result is None if mission.begun else pending
            case SwitchControl():
                return not mission.begun and pending
            case _:
                return False

    def _conditions(self, state: EngineState) -> Watch | None:
        """Return what must stay true, until a fault rule has held for long enough."""
        robot, body = self._robot, state.robot
        rules, due_s = self._rules(state)
        command = command_conditions(robot, body, state.faults.raised)
        if command is None:
            return None
        waiting = self._triggers(state)
        return Watch(
            robot,
            state.sensing,
            body.values,
            body.latest,
            body.latest if body.sent else (),
            state.mission.origin,
            rules,
            (*command, *waiting),
            same_duties(robot, body),
            state.surveyed,
            tuple(held_parts(robot, body, state.faults.raised)),
            in_bend=False,
            frames_until_s=due_s,
            wake_s=inf,
            deadline_s=inf,
            word=None,
            word_until_s=inf,
            alarm_s=inf,
            listening_s=inf,
        )

    def _rules(self, state: EngineState) -> tuple[tuple[Condition, ...], float]:
        """Return the fault rules, and when one that holds must be raised."""
        words, faults = state.obeyed_words(self._robot), state.faults
        holding = [not isnan(began) for began in faults.since]
        due_s = min(
            (
                faults.since[index] + self._robot.faults[index].held_s
                for index, holds in enumerate(holding)
                if holds and index not in faults.raised
            ),
            default=inf,
        )
        return self._codes.rules(words, holding), due_s

    def _triggers(self, state: EngineState) -> list[Condition]:
        mission = state.mission
        it = self._program.instructions[mission.pc]
        if not isinstance(it, Wait) or mission.paused:
            return []
        return [
            condition
            for trigger, since in zip(it.triggers, mission.since, strict=True)
            if trigger.condition is not None
            for condition in self._codes.trigger(trigger.condition, state.words, not isnan(since))
        ]


def _same(old: EngineState, new: EngineState) -> bool:
    """Return whether two states differ in signals and times only."""
    return (
        old.robot is new.robot
        and old.mission is new.mission
        and old.faults is new.faults
        and old.words == new.words
    )


def _is_settled(robot: RobotSpec, surveyed: Surveyed, word: str | None) -> bool:
    """Return whether a survey without a step of the diameter finds the same joint as the last."""
    before = surveyed.joint
    around, joint = joint_around(robot, before, word, announced(robot, surveyed, word), nan)
    inside = surveyed.outside_until_s == -inf
    return inside and around == before and joint == surveyed.reported.joint


def _calm(state: EngineState) -> bool:
    """Return whether the start check is over, and every signal known to be that of a sensor."""
    sensing, faults = state.sensing, state.faults
    return (
        state.look is None
        and state.lapsed is None
        and not faults.silent
        and not faults.blind
        and not sensing.stale
        and not sensing.told
        and not sensing.adrift
        and not sensing.sees_slip
    )


def _sensors_are_calm(robot: RobotSpec, sensing: Sensing) -> bool:
    """Return whether every sensor is believed."""
    hold_back = robot.plausibility.hold_back
    return not any(record.special or record.seen <= hold_back for record in sensing.records)


def _runs(mission: MissionState) -> bool:
    """Return whether nothing is to be begun or ended: a pause, the handling of a fault, the run.

    A pause may go on, with the robot under the operator's commands, unless it suspends a command.
    """
    return (
        mission.ending is None
        and not mission.ended
        and not mission.suspended
        and not mission.pause_wanted
        and mission.diverting is None
        and mission.answer is None
        and mission.skipped is None
    )


def _is_covered(body: RobotState) -> bool:
    """Return whether no loop remembers anything, and no array of a stream is on its way."""
    if body.overtaken or (body.flight is not None and body.flight.purpose == "stream"):
        return False
    return all(isinstance(loop, RunningPositionLoop) for loop in body.loops)
