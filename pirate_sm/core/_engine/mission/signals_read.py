"""Find the signals by which a mission and its robot decide anything."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import isnan

from pirate_sm.core._engine.mission.program import (
    DRIVEN,
    Branch,
    Do,
    Enter,
    Finish,
    Program,
    Question,
    Raise,
    Require,
    Say,
    SwitchControl,
    Wait,
)
from pirate_sm.core._engine.robot.command_spec import GripSpec
from pirate_sm.core._engine.robot.criteria import BelowSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._expressions import Expression

_WITH_TEXT = (Finish, Raise, Say)


def signals_read(robot: RobotSpec, program: Program) -> frozenset[int]:
    """Return the number indexes of signals in conditions, texts, fault rules, criteria and grips.

    Grips count that estimate the friction, which takes many rounds, where the mission uses their
    control; each run begins with the usual one. Grips that know the friction read slip while their
    control is in force, see :func:`slip_watched`.
    Not among them: angles, rates, torques and diameters that a robot's own parts are made of.
    """
    places = {name: at for at, name in enumerate(robot.vocabulary.with_changes.numbers)}
    count = len(robot.vocabulary.numbers)  # the changes of the signals come after them
    conditions = (*_conditions(program), *(rule.when for rule in robot.faults))
    named = {places[name] % count for each in conditions for name in each.names if name in places}
    if any(DRIVEN in it.message for it in program.instructions if isinstance(it, _WITH_TEXT)):
        named.add(robot.odometry)
    return frozenset((*named, *_in_criteria(robot), *_in_grips(robot, program)))


def slip_watched(robot: RobotSpec) -> Iterator[tuple[int, frozenset[int]]]:
    """Yield the controls whose grips watch slip, each with the number indexes of its signals."""
    for control in range(len(robot.controls)):
        signals = frozenset(index for grip in _grips(robot, control) for index in grip.slip_speeds)
        if signals:
            yield control, signals


def _conditions(program: Program) -> Iterator[Expression]:
    for it in program.instructions:
        match it:
            case Branch(condition=condition):
                yield condition
            case Wait(triggers=triggers):
                yield from (each.condition for each in triggers if each.condition is not None)
            case (
                Do() | Enter() | Finish() | Question() | Raise() | Require() | Say()
                | SwitchControl()
            ):  # fmt: skip
                pass


@lru_cache(maxsize=8)
def _in_criteria(robot: RobotSpec) -> frozenset[int]:
    criteria = [each.done for each in robot.commands]
    criteria += [each.done for it in robot.commands for each in it.postures if each is not None]
    return frozenset(n for done in criteria if isinstance(done, BelowSpec) for n in done.signals)


def _in_grips(robot: RobotSpec, program: Program) -> Iterator[int]:
    switches = [it for it in program.instructions if isinstance(it, SwitchControl)]
    for control in {0, *(it.control for it in switches)}:
        for grip in _grips(robot, control):
            if isnan(grip.friction):
                yield from (*grip.estimates, *grip.slip_speeds)


@lru_cache(maxsize=64)
def _grips(robot: RobotSpec, control: int) -> tuple[GripSpec, ...]:
    """Return the grips of a control."""
    stages = [each for states in robot.controls[control].actuation for each in states.values()]
    writes = (write for each in stages for stage in each for write in stage)
    return tuple(write.grip for write in writes if write.grip is not None)
