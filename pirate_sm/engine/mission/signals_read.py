"""Find the signals by which a mission and its robot decide anything."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.engine.mission.program import (
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
from pirate_sm.engine.robot.criteria import BelowSpec
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.expressions import Expression


def signals_read(robot: RobotSpec, program: Program) -> frozenset[int]:
    """Return the number indexes of signals in conditions, fault rules, criteria and grips.

    Grips count where the mission uses their control; each run begins with the usual one.
    Not among them: angles, rates, torques and diameters that a robot's own parts are made of.
    """
    places = {name: at for at, name in enumerate(robot.vocabulary.with_changes.numbers)}
    count = len(robot.vocabulary.numbers)  # the changes of the signals come after them
    conditions = (*_conditions(program), *(rule.when for rule in robot.faults))
    named = {places[name] % count for each in conditions for name in each.names if name in places}
    return frozenset((*named, *_in_criteria(robot), *_in_grips(robot, program)))


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


def _in_criteria(robot: RobotSpec) -> Iterator[int]:
    for command in robot.commands:
        postures = (posture.done for posture in command.postures if posture is not None)
        for done in (command.done, *postures):
            if isinstance(done, BelowSpec):
                yield from done.signals


def _in_grips(robot: RobotSpec, program: Program) -> Iterator[int]:
    switches = [it for it in program.instructions if isinstance(it, SwitchControl)]
    for control in {0, *(it.control for it in switches)}:
        for states in robot.controls[control].actuation:
            writes = (each for stages in states.values() for stage in stages for each in stage)
            for write in writes:
                if write.grip is not None:
                    yield from (*write.grip.estimates, *write.grip.slip_speeds)
