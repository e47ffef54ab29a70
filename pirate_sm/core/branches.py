"""The branches of a mission: each way on from a place at which there is more than one.

A program declares its branches, and the engine notes each that it takes in ``Moment.taken``. Both
name them by kind and place, so that the rounds of a repeat and all calls of a mission count
together.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.mission.program import (
    Branch,
    BranchKey,
    BranchKind,
    Do,
    Enter,
    Finish,
    Instruction,
    Program,
    Question,
    Raise,
    Require,
    Say,
    SwitchControl,
    Wait,
)
from pirate_sm.core._engine.robot.robot_state import RESTORING


class MissionBranch(NamedTuple):
    """A branch that a mission has.

    Attributes:
        what: What leads there: the trigger, the condition, the command that fails, the fault.
        leads: The phase or end to which it leads; ``continue`` for the next step.
    """

    key: BranchKey
    what: str
    leads: str

    @property
    def words(self) -> str:
        """Return what it is, in a line."""
        return f"{self.key.kind}: {' '.join(self.what.split())} → {self.leads}"


def branches(program: Program, commands: tuple[str, ...]) -> dict[BranchKey, MissionBranch]:
    """Return all branches of a mission, in the order of its instructions.

    A failure that nothing handles, and a fault without a handler, do not count: they end the
    mission. Commands that a resumed run gives before it continues are in no file and do not either.

    Args:
        program: The mission.
        commands: The names of the robot's commands.
    """
    found: dict[BranchKey, MissionBranch] = {}
    for at, it in enumerate(program.instructions):
        for kind, place, name, what, target in _ways(program, it, commands):
            if place not in ("", RESTORING) and (target >= 0 or kind == "within"):
                key = BranchKey(kind, place, name)
                found.setdefault(key, MissionBranch(key, what, _name(program, at, target)))
        for each in program.handlers[at]:
            key = BranchKey("on_fault", each.place, each.code)
            of = f" of {', '.join(sorted(each.of))}" if each.of else ""
            leads = each.go_name if each.go is not None else CONTINUE
            found.setdefault(key, MissionBranch(key, f"{each.code}{of}", leads))
    return found


CONTINUE = "continue"
"""Where a branch leads that continues with the next step."""
FAIL = "fail"
"""Where a time limit leads whose failure nothing handles: to the end of the mission."""

_Way: TypeAlias = tuple[BranchKind, str, str, str, int]


def _ways(  # noqa: C901 - one case for each kind of instruction
    program: Program, it: Instruction, commands: tuple[str, ...]
) -> Iterator[_Way]:
    """Yield kind, place, name, words and target of each branch of an instruction."""
    match it:
        case Wait():
            for each in it.triggers:
                yield "trigger", each.place, each.name, each.text, each.go
            if it.within_s < inf:
                yield "within", it.place, "", f"{it.within_s:g} s have passed", it.within
        case Branch():
            yield "if", it.place, "", it.condition.text, it.if_true
            yield "else", it.place, "", f"not {it.condition.text}", it.if_false
        case Question():
            yield from (("choice", it.place, each, each, to) for each, to in it.choices)
            if it.timeout_s < inf:
                yield "on_failure", it.place, "", f"no answer to '{it.text}'", it.failed
        case Do():
            name = commands[it.command]
            yield "on_failure", it.place, "", f"{name} fails", it.failed
            if it.retries:
                yield "retry", it.place, "", f"{name} is given again", it.next
        case SwitchControl():
            yield "on_failure", it.place, "", "the control fails", it.failed
        case Require():
            if it.states:
                yield "on_failure", it.place, "", f"{it.what} fails", it.failed
        case Raise():
            yield "on_failure", it.place, "", it.message, it.failed
        case Enter(resume=int() as target):
            entered = getattr(program.instructions[target], "place", "")
            yield "resume", entered, "", "a run is resumed", target
        case Enter() | Say() | Finish():
            pass


def _name(program: Program, at: int, target: int) -> str:
    """Return the phase or end at a target; ``continue`` within a phase."""
    if target < 0:
        return FAIL
    it = program.instructions[target]
    end = getattr(it, "end", "")
    home = program.phase_of[target]
    stays = home == program.phase_of[at] and not isinstance(it, Enter)
    return end or (CONTINUE if stays else home or CONTINUE)
