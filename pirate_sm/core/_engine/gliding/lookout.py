"""Find what must stay true so that frames change nothing but signals.

Each condition here stands for a part of :meth:`pirate_sm.core._engine.engine.Engine.step` that
would do something if it changed. Where a part has no such condition, nothing is watched, and every
frame goes through the engine. Conditions of a robot and of its mission become code, each compiled
once for the words that it meets.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import inf, isnan, nan

from pirate_sm.core._engine.consequences import deadline_s, listening_s
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.gliding.comparison import compared
from pirate_sm.core._engine.gliding.quiet_frames import (
    ANY_BOARD,
    Condition,
    SameDuty,
    Watch,
)
from pirate_sm.core._engine.mission.program import Do, Question, SwitchControl, Wait
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.command_outcome import why_not_clamped
from pirate_sm.core._engine.robot.criteria import Bound, CriterionSpec, JointsArrived, arrived
from pirate_sm.core._engine.robot.loops import RunningPositionLoop
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    POSTURE,
    Motion,
    RobotState,
    criteria_of,
    posture_bounds,
    posture_of,
)
from pirate_sm.core._engine.sensing.environment import Surveyed, announced, held_parts, joint_around
from pirate_sm.core._engine.sensing.plausibility import BoardMemory
from pirate_sm.core._engine.state import EngineState, MissionState
from pirate_sm.core._expressions import Expression, tree
from pirate_sm.core._expressions.compiler import Code, Words, code_of, never_true, words_in

# --- conditions as code -----------------------------------------------------------------------


@lru_cache(maxsize=16)
def _codes_of(robot: RobotSpec) -> Codes:
    """Return the codes of a robot, which all engines that run it share."""
    return Codes(robot)


class Codes:
    """Compiles the fault rules of a robot and the triggers of its missions.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._known: dict[tuple[int, Words], Code] = {}
        self._read: dict[int, tuple[Expression, tuple[int, ...]]] = {}
        self._rules: dict[tuple[Words, Sequence[bool]], tuple[Condition, ...]] = {}
        trees = [rule.when.tree for rule in robot.faults]
        self._tested = sorted({index for tree in trees for index in words_in(tree)})
        self._boards = [0] * len(robot.faults)
        for board in robot.boards.values():
            for rule in board.faults:
                self._boards[rule] |= 1 << board.position

    def rules(self, words: Words, holding: Sequence[bool]) -> tuple[Condition, ...]:
        """Return the fault rules as conditions, without those that cannot become true.

        Args:
            words: What the signals with words are.
            holding: Per rule whether it is true.
        """
        key = tuple([words[index] for index in self._tested]), tuple(holding)
        found = self._rules.get(key)
        if found is None:
            pairs = zip(self._robot.faults, holding, self._boards, strict=True)
            rows = [self._condition(rule.when, words, holds, of) for rule, holds, of in pairs]
            found = self._rules[key] = tuple(each for row in rows for each in row)
        return found

    def trigger(self, condition: Expression, words: Words, holds: bool) -> tuple[Condition, ...]:
        """Return the condition of a trigger; nothing if it cannot become true."""
        return self._condition(condition, words, holds, ANY_BOARD)

    def _condition(
        self, expression: Expression, words: Words, holds: bool, boards: int
    ) -> tuple[Condition, ...]:
        code = self._code(expression, words)
        return () if not holds and never_true(code) else (Condition(code, holds, boards),)

    def _code(self, expression: Expression, words: Words) -> Code:
        own = id(expression)
        if own not in self._read:  # the expression is kept with it, so that its id stays its own
            self._read[own] = expression, words_in(expression.tree)
        seen = tuple([words[index] for index in self._read[own][1]])
        code = self._known.get((own, seen))
        if code is None:
            code = self._known[own, seen] = code_of(expression.tree, words)
        return code


# --- the command under way --------------------------------------------------------------------


def _command_conditions(
    robot: RobotSpec, body: RobotState, raised: frozenset[int]
) -> list[Condition] | None:
    """Return the conditions under which the command under way neither ends nor goes on.

    Args:
        robot: The robot.
        body: Its commanded state.
        raised: Fault rules that are raised.

    Returns:
        The conditions; None where every frame must go through the engine.
    """
    motion = body.motion
    if motion is None or isnan(motion.accepted_s):
        return []
    if motion.blind or (motion.levelling is not None and motion.stage != POSTURE):
        return None
    denied = robot.denied_by(raised)
    criteria, seekers = criteria_of(robot, motion), body.seekers
    if denied and why_not_clamped(body, motion, denied):
        resting = all(isnan(since_s) for _, since_s in criteria)
        return _followed(robot, body, motion) if resting else None
    there = posture_bounds(robot, body, motion)
    found = _followed(robot, body, motion)
    for done, since_s in criteria:
        holds = not isnan(since_s)
        found.append(Condition(_done(done, body.values, seekers, there), holds, ANY_BOARD))
        if holds and done.asked(JointsArrived):  # it need not last once every joint is there
            found.append(
                _condition(tree.And(tuple(arrived(each).condition for each in seekers)), False)
            )
    return found


def _same_duties(robot: RobotSpec, body: RobotState) -> tuple[SameDuty, ...]:
    """Return the loops whose duties would be sent if they changed.

    While an array is awaited, or while no command runs that has been accepted, none is sent.
    """
    motion = body.motion
    if motion is None or isnan(motion.accepted_s) or body.awaited is not None:
        return ()
    return tuple(
        SameDuty(
            loop.angle,
            loop.target_rad,
            *loop.spec[:4],
            robot.slots[loop.slot].resolution,
            body.latest[loop.slot],
        )
        for loop in body.seekers
    )


@lru_cache(maxsize=4096)
def _done(
    done: CriterionSpec,
    setpoints: Numbers,
    seekers: tuple[RunningPositionLoop, ...],
    there: tuple[Bound, ...],
) -> Code:
    """Return the code of a criterion; in a posture every joint must be at its angle too."""
    parts = (done.condition(setpoints, seekers), *(each.condition for each in there))
    return code_of(tree.And(parts))


def _followed(robot: RobotSpec, body: RobotState, motion: Motion) -> list[Condition]:
    """Return that no loop of a posture takes another share of a joint's angle."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return []
    loops = {loop.slot: loop for loop in body.loops if isinstance(loop, RunningPositionLoop)}
    return [
        _condition(_has_moved(loops[write.slot], write.share_of, write.value), False)
        for write in posture.writes
        if write.share_of >= 0 and write.slot in loops
    ]


def _has_moved(loop: RunningPositionLoop, share_of: int, value: float) -> tree.Node:
    """Return whether the loop would be begun anew for an angle that is a share of another."""
    target = tree.Arithmetic("*", tree.Number(value), tree.Signal("", "number", share_of))
    off = tree.Arithmetic("-", target, tree.Number(loop.target_rad))
    return tree.Compare(">", tree.Call("abs", (off,)), tree.Number(loop.spec.threshold_rad))


def _condition(node: tree.Node, holds: bool, boards: int = ANY_BOARD) -> Condition:
    return Condition(code_of(node), holds, boards)


# --- all of a run -----------------------------------------------------------------------------


class Lookout:
    """Tells what must stay true, for one engine.

    What it has found is remembered, because most of it stays the same for long.

    Args:
        engine: The engine.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._robot = engine.robot
        self._program = engine.program
        self._codes = _codes_of(engine.robot)
        self._moment = Moment(engine.robot, engine.program, nominal=False, now_s=0.0)
        self._last: tuple[EngineState, Watch, float] | None = None
        self._records: tuple[BoardMemory, ...] = ()
        self._doubting: tuple[Condition, ...] = ()

    def watch(self, state: EngineState) -> Watch | None:
        """Return what must stay true so that frames of the boards change nothing but signals.

        A backend may then take such frames for the engine, see :meth:`Glided.applied_to`.

        Returns:
            What must stay true; None where every frame must go through the engine.
        """
        engine = self._engine
        if engine.nominal or engine.follows_slip(state) or state.mission.ended:
            return None
        records = state.sensing.records
        if records is not self._records:
            self._records, self._doubting = records, tuple(_doubting(records))
        if not _calm(state):
            return None
        if self._judges(state):
            return None
        if self._last is None or not _same(self._last[0], state):
            if not (_runs(state.mission) and _is_covered(state.robot)):
                return None
            if state.look is None and not self._waits(state.mission, state.robot):
                return None
            found = self._conditions(state)
            if found is None:
                return None
            self._last = state, found, deadline_s(self._moment, state)
        _, watch, deadline = self._last
        robot, surveyed, word = self._robot, state.surveyed, state.outside("detector")
        in_bend = announced(robot, surveyed, word)
        settled = _is_settled(robot, surveyed, word, in_bend=in_bend)
        alarm, listening = min(deadline, state.word_until_s), listening_s(robot, state.sensing)
        if not settled or state.wake_at_s != min(alarm, listening):
            # The engine must survey, or has not been told yet when it will be called.
            alarm, listening = min(alarm, state.wake_at_s), inf
        survey_s = inf if settled else surveyed.due_s
        judged_s = state.sensing.distance.due_s if state.sensing.distance.running else inf
        return watch._replace(
            sensing=state.sensing,
            conditions=(*self._doubting, *watch.conditions),
            surveyed=surveyed,
            in_bend=in_bend,
            frames_until_s=min(watch.frames_until_s, survey_s, judged_s),
            wake_s=state.wake_at_s,
            deadline_s=deadline,
            word=word,
            word_until_s=state.word_until_s,
            alarm_s=alarm,
            listening_s=listening,
        )

    def _judges(self, state: EngineState) -> bool:
        """Return whether odometry begins to be judged with the next frame."""
        memory, latest = state.sensing.distance, state.robot.latest
        begins = memory.every_s > 0 and not memory.running
        return begins and any(latest[wheel.slot] for wheel in self._robot.wheels)

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
        command = _command_conditions(robot, body, state.faults.raised)
        marks = compared(robot, state, self._program.diameter_m)
        if command is None or marks is None:
            return None
        waiting = self._triggers(state) if state.look is None else ()
        return Watch(
            robot,
            state.sensing,
            body.values,
            body.latest,
            body.latest if body.sent else (),
            state.mission.origin,
            rules,
            (*command, *marks, *waiting),
            _same_duties(robot, body),
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
        and old.look is new.look
        and old.lapsed is new.lapsed
    )


def _is_settled(robot: RobotSpec, surveyed: Surveyed, word: str | None, *, in_bend: bool) -> bool:
    """Return whether a survey without a step of the diameter finds the same joint as the last."""
    before = surveyed.joint
    around, joint = joint_around(robot, before, word, in_bend, nan)
    if surveyed.merged_until_s < inf:
        joint = surveyed.outside.joint or joint
    return around == before and joint == surveyed.reported.joint


def _calm(state: EngineState) -> bool:
    """Return whether no signal is too old or from outside."""
    sensing, faults = state.sensing, state.faults
    return (
        not faults.silent
        and not faults.blind
        and not sensing.stale
        and not sensing.told
        and not sensing.adrift
        and not sensing.sees_slip
    )


def _doubting(records: Sequence[BoardMemory]) -> Iterator[Condition]:
    """Yield a condition that no frame leaves as it is, for each board with a doubted sensor."""
    for position, record in enumerate(records):
        if record.special:
            yield _condition(tree.TruthValue(True), False, 1 << position)


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
