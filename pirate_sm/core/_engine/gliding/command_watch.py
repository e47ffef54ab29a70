"""What of a command under way frames must leave as it is; see ``_engine/robot``."""

from __future__ import annotations

from functools import lru_cache
from math import isnan

from pirate_sm.core._engine.control.position_loop import RunningPositionLoop
from pirate_sm.core._engine.gliding.conditions import ANY_BOARD
from pirate_sm.core._engine.gliding.watch import Condition, SameDuty
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import CriterionSpec, ReachedSpec
from pirate_sm.core._engine.robot.done import Bound, arrived, criterion_tree
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    POSTURE,
    Motion,
    RobotState,
    criteria_of,
    posture_of,
)
from pirate_sm.core._engine.robot.unmet_conditions import posture_bounds, why_not_clamped
from pirate_sm.core._expressions import tree
from pirate_sm.core._expressions.bytecode import Code, code_of


def command_conditions(
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
        if holds and isinstance(done, ReachedSpec):  # it need not last once every joint is there
            found.append(
                _condition(tree.And(tuple(arrived(each).condition for each in seekers)), False)
            )
    return found


def same_duties(robot: RobotSpec, body: RobotState) -> tuple[SameDuty, ...]:
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
            loop.spec.threshold_rad,
            loop.spec.gain,
            loop.spec.least_duty,
            loop.spec.limit,
            robot.slots[loop.slot].resolution,
            body.latest[loop.slot],
        )
        for loop in body.seekers
    )


@lru_cache(maxsize=4096, typed=True)  # criteria of two kinds can be equal as tuples
def _done(
    done: CriterionSpec,
    setpoints: Numbers,
    seekers: tuple[RunningPositionLoop, ...],
    there: tuple[Bound, ...],
) -> Code:
    """Return the code of a criterion; in a posture every joint must be at its angle too."""
    parts = (criterion_tree(done, setpoints, seekers), *(each.condition for each in there))
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


def _condition(node: tree.Node, holds: bool) -> Condition:
    return Condition(code_of(node), holds, ANY_BOARD)
