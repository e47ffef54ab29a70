"""Evaluate safety rules: during every run, and before a command that could break one is sent.

Conditions of rules see the commanded robot. Words: the state of each region, and the command just
accepted. Numbers: how many parts are held, how many are confirmed to hold, and how many wheels are
driven. The progress of a rule is one integer: the number of commands that may still be accepted
until it must hold, or one of two special values.
"""

from __future__ import annotations

from pirate_sm.core._engine.mission.program import Program, RuleSpec
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState, confirmed_parts, states_of
from pirate_sm.core._model.events import SubmitResult
from pirate_sm.core._model.faults import BuiltInFault

NUMBERS = ("clamps", "confirmed_clamps", "driven_wheels")
"""The numbers that conditions of rules can use, in this order."""

COMMAND = "command"
"""The word after the regions: the command just accepted; unknown at other times."""

CODE = BuiltInFault.RULE_VIOLATED.code

_NOT_YET = -1
_IN_FORCE = 0


def unseen(program: Program) -> tuple[int, ...]:
    """Return the initial progress of every rule."""
    return (_NOT_YET,) * len(program.rules)


def follow(
    program: Program,
    robot: RobotSpec,
    before: tuple[int, ...],
    body: RobotState,
    steps: int,
    command: str | None = None,
) -> tuple[tuple[int, ...], tuple[RuleSpec, ...]]:
    """Return the progress of every rule for this state of the robot, and the violated rules.

    Args:
        program: The program with the rules.
        robot: The robot.
        before: The progress of the rules so far.
        body: The commanded state of the robot.
        steps: How many commands have been accepted since ``before``.
        command: The command just accepted, if any.
    """
    if not program.rules:
        return (), ()
    driven = sum([body.values[slot] != 0 for slot in robot.safe_zero])
    numbers = (
        float(len(robot.held[body.configuration])),
        float(len(confirmed_parts(robot, body))),
        float(driven),
    )
    words = (*states_of(robot, body), command)
    after, broken = [], []
    for rule, at in zip(program.rules, before, strict=True):
        begins = rule.after is None or rule.after.evaluate(numbers, words) is True
        holds = rule.must.evaluate(numbers, words)
        if rule.within is None:
            now = _IN_FORCE if begins or at == _IN_FORCE else _NOT_YET
            violated = now == _IN_FORCE and holds is False  # unknown where no command is accepted
        elif holds:
            now, violated = _NOT_YET, False
        elif at > 0:
            now = max(at - steps, 0)
            violated = now == 0
        else:
            now, violated = (rule.within if begins else _NOT_YET), False
        after.append(now)
        if violated:
            broken.append(rule)
    return tuple(after), tuple(broken)


def broken(moment: Moment, places: tuple[int, ...], body: RobotState) -> tuple[RuleSpec, ...]:
    """Return the rules that the robot breaks in this state, although no command is accepted."""
    return follow(moment.program, moment.robot, places, body, 0)[1]


def forbids(moment: Moment, places: tuple[int, ...], begun: RobotState) -> str:
    """Return the rules that a command would break at its acceptance, as text; empty if none.

    Args:
        moment: The context, with robot and program.
        places: The progress of the rules.
        begun: The robot after the command has begun.
    """
    flight, motion = begun.flight, begun.motion
    if not places or flight is None or motion is None:
        return ""
    accepted = SubmitResult(flight.setpoint_id, "accepted")
    body, _ = commands.resolve(moment.trial(), begun, accepted)
    name = moment.robot.commands[motion.command].name
    _, broken = follow(moment.program, moment.robot, places, body, 1, name)
    return "; ".join(said(rule) for rule in broken)


def said(rule: RuleSpec) -> str:
    """Return the rule as one line of text."""
    return f"rule {rule.name} ({rule.text})" + (f": {rule.why}" if rule.why else "")
