"""Decide where a mission continues after a crash, how it starts, and what remains unknown."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import replace
from math import isnan, nan
from typing import NamedTuple

from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission import planning
from pirate_sm.core._engine.mission.program import (
    HERE,
    NEVER,
    STOP,
    Branch,
    Do,
    Enter,
    Instruction,
    Program,
    Wait,
)
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.resuming.hypotheses import Hypothesis
from pirate_sm.core._engine.resuming.reconciling import VerdictTable
from pirate_sm.core._engine.robot.evidence import kind_of
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    RESTORING,
    STOPPED,
    Mark,
    RobotState,
    states_of,
)
from pirate_sm.core._engine.sensing.known_signals import DistanceMemory, nothing_known
from pirate_sm.core._engine.state import Counted, EngineState
from pirate_sm.core._engine.unwatched import DarkWay, odometry_m

FAILURE = "failure"
"""Go on where a failure of the present step leads."""


class Entry(NamedTuple):
    """Where a mission goes on.

    Attributes:
        pc: Index of the instruction, in the program that was recorded.
        restoring: Commands, by index, that confirm again what was confirmed when the run was cut
            off: clamps first, wheels last. One that is unneeded is left out during the run.
        armed_s: For a wait, how long it had been armed; its time limit goes on from there.
        origin: The signals from which a wait counts that counts on; a change of a signal that is
            NaN here stays unknown. Empty where no wait has counted.
        by_resume: Whether the phase in which the run was interrupted names it with ``resume``.
    """

    pc: int
    restoring: tuple[int, ...] = ()
    armed_s: float = 0.0
    origin: Numbers = ()
    by_resume: bool = False


class Refused(NamedTuple):
    """The mission cannot go on, and why."""

    reason: str


def entry(
    robot: RobotSpec,
    program: Program,
    last: EngineState,
    last_s: float,
    body: RobotState,
    at: str = HERE,
    *,
    lost: AbstractSet[int] = frozenset(),
) -> Entry | Refused:
    """Return where the mission goes on.

    It continues with the instruction that it was at, begun anew: what was done is not repeated, a
    command under way is given again, a wait is armed again for the rest of its time limit, a
    question is asked again. The phase's key ``resume`` may say otherwise.

    Args:
        robot: The robot.
        program: The program that was recorded.
        last: The engine's last recorded state.
        last_s: When that was, s.
        body: The robot as it is taken to be, with everything unconfirmed.
        at: ``here``; ``failure``, where a failure of the present step leads; or a phase.
        lost: Number indexes of signals that do not count from the same value any more.
    """
    mission = last.mission
    if mission.ended or mission.ending is not None:
        return Refused("the mission had come to its end")
    pc = _goal(program, mission.pc)
    other = _elsewhere(program, last, pc, body.control, at)
    if isinstance(other, Refused):
        return other
    origin = tuple(nan if index in lost else was for index, was in enumerate(mission.origin))
    if other is not None:
        given = _restoring(robot, program, last, body, drives=False)
        named = at == HERE and isinstance(program.entered(pc).resume, int)
        return Entry(other, given, origin=origin, by_resume=named)
    before = mission.before_pause
    if before is not None and before.configuration != last.robot.configuration:
        return Refused("it was paused, and the operator had changed the configuration since")
    again = _restoring(robot, program, last, body, drives=True)
    if not mission.begun or not isinstance(program.instructions[mission.pc], Wait):
        return Entry(pc, again, origin=origin)
    return Entry(pc, again, mission.clock(last_s) - mission.armed_s, origin)


def _elsewhere(
    program: Program, last: EngineState, pc: int, control: int, at: str
) -> int | Refused | None:
    """Return the instruction at which the mission goes on if that is not its present one."""
    phase, entered = program.phase_of[pc], program.entered(pc)
    if at == FAILURE:
        failed = getattr(program.instructions[pc], "failed", entered.failed)
        if failed == STOP:
            return Refused(f"no `on_failure` handles a failure in {phase}")
        return int(failed)
    if at != HERE:
        begin = program.beginning(at, control)
        return Refused(f"the mission has no phase {at}") if begin is None else begin
    if entered.resume == NEVER:
        return Refused(f"the mission does not go on in {phase}: it says `resume: never` there")
    if isinstance(entered.resume, int):
        wanted = program.phase_of[entered.resume]
        return program.beginning(wanted, control) if program.entries else entered.resume
    diverting = last.mission.diverting
    return None if diverting is None else diverting.go


def resumed_program(program: Program, it: Entry) -> Program:
    """Return the program that begins at an entry: the same instructions, and more at the end.

    These enter the phase, give the restoring commands and do what the entry's instruction does: a
    wait that was armed has only the rest of its time limit, and a command counts as done if it is
    unneeded now.
    """
    instructions, first = program.instructions, len(program.instructions)
    goal, entered, home = instructions[it.pc], program.entered(it.pc), program.phase_of[it.pc]
    failed = getattr(goal, "failed", entered.failed)
    added: list[Instruction] = [Enter(home, first + 1, entered.failed, entered.resume)]
    added += [
        Do(command, None, 0, True, first + 2 + number, failed, RESTORING)
        for number, command in enumerate(it.restoring)
    ]
    match goal:
        case Wait():
            goal = _rest_of(goal, it)
        case Do():
            goal = goal._replace(skip_unneeded=True)
        case _:
            pass
    added.append(goal)
    count = len(added)
    turn = program.turn_of[it.pc] if it.pc < len(program.turn_of) else ""
    return replace(
        program,
        instructions=(*instructions, *added),
        start=first,
        handlers=(*program.handlers, *(program.handlers[it.pc],) * count),
        phase_of=(*program.phase_of, *(home,) * count),
        turn_of=(*program.turn_of, *(turn,) * count),
    )


def _goal(program: Program, pc: int) -> int:
    """Return the instruction to which the restoring commands of an earlier resumption lead."""
    it = program.instructions[pc]
    while isinstance(it, Do) and it.place == RESTORING:
        pc = it.next
        it = program.instructions[pc]
    return pc


def _rest_of(wait: Wait, it: Entry) -> Wait:
    triggers = tuple(
        each if each.after_s is None else each._replace(after_s=max(0.0, each.after_s - it.armed_s))
        for each in wait.triggers
    )
    within_s = max(0.0, wait.within_s - it.armed_s)
    counts_on = wait.counts_on or it.armed_s > 0.0
    return wait._replace(within_s=within_s, triggers=triggers, counts_on=counts_on)


def _restoring(
    robot: RobotSpec, program: Program, last: EngineState, body: RobotState, *, drives: bool
) -> tuple[int, ...]:
    """Return commands that confirm what was confirmed and stay in the configuration.

    Clamps come first and wheels that were driven come last. What the recording had not confirmed
    is left as it is.

    Args:
        robot: The robot.
        program: The program with the safety rules in force.
        last: The engine's last recorded state.
        body: The robot with its marks.
        drives: Whether wheels that were driven are to be driven again.
    """
    given: list[int] = []
    recorded = {
        (mark.kind, mark.which)
        for mark in last.robot.marks
        if mark.command not in (DECLARED, STOPPED)
    }

    def open_(body: RobotState) -> frozenset[Mark]:
        """Return the marks that these commands shall remove."""
        driven = robot.driven[body.configuration]
        return frozenset(
            mark
            for mark in body.marks
            if mark.command < 0
            and (mark.kind, mark.which) not in recorded
            and (drives or mark.kind == "part" or mark.which not in driven)
        )

    sensing = nothing_known(robot, blind=True)
    places, _ = safety.follow(program, robot, safety.unseen(program), body, 0)

    def order(found: tuple[planning.PlannedStep, planning.RulePlaces]) -> tuple[bool, bool, int]:
        step, _ = found
        clamps = any(mark.kind == "part" for mark in open_(body) - open_(step.body))
        return _turns(robot, step.body), not clamps, step.command

    while True:
        found = [
            (step, after)
            for step, after in planning.next_steps(robot, program, sensing, body, places)
            if step.body.configuration == body.configuration
            and not step.hindrance
            and not robot.commands[step.command].lets_go
            and (drives or not _turns(robot, step.body))
            and body.marks - step.body.marks <= open_(body)
            and open_(step.body) < open_(body)
        ]
        if not found:
            return tuple(given)
        step, places = min(found, key=order)
        given.append(step.command)
        body = step.body


def _turns(robot: RobotSpec, body: RobotState) -> bool:
    return any(body.values[slot] for slot in robot.safe_zero)


# --- with what it starts ----------------------------------------------------------------------


class Resumption(NamedTuple):
    """With what a mission goes on; ``Engine.start`` takes it, with :attr:`program` as its program.

    All of it is plain data that a recording can hold as text; :func:`resumed_program` makes
    the program again from the entry and the program of the run before.

    Attributes:
        entry: Where it goes on.
        body: The robot at rest, with nothing confirmed; its values are those of the first array.
        clock_s: Mission time at which the run was cut off, which goes on from there.
        cause: Reason of the last failure or fault; ``handling``: the phase that handles a fault.
        paused: Whether the operator had paused the mission.
        rules: Progress of the safety rules.
        odometry_m: Odometry at the start; NaN if the robot has none.
        adrift: Whether that is not known, so that conditions see only its changes from now on.
        distance: What is remembered to judge the odometry.
        counts_from: See :class:`.MissionState`, likewise ``claim``.
    """

    entry: Entry
    body: RobotState
    clock_s: float = 0.0
    cause: str = ""
    handling: str = ""
    paused: bool = False
    rules: tuple[int, ...] = ()
    odometry_m: float = nan
    adrift: bool = False
    distance: DistanceMemory = DistanceMemory()
    counts_from: Counted = Counted()
    claim: Counted | None = None

    def program(self, before: Program) -> Program:
        """Return the program of the resumed run, from that of the run before."""
        return resumed_program(before, self.entry)

    def positions_read(self, robot: RobotSpec, program: Program) -> Iterator[tuple[int, str]]:
        """Yield where its program reads a position that is unknown, see `position_read`."""
        if self.adrift:
            yield from position_read(robot, program, self.entry.origin)

    def unknown_position(self, robot: RobotSpec, program: Program) -> str:
        """Return where its program first reads a position that is unknown; empty if nowhere."""
        place = next((place for _, place in self.positions_read(robot, program)), "")
        return f"the position: the mission reads it ({place})" if place else ""


class Beginning(NamedTuple):
    """How a mission begins where that is not as it is declared; see ``Engine.start``."""

    body: RobotState | None = None
    paused: bool = False
    resumed: Resumption | None = None


AS_DECLARED = Beginning()


def resumption(
    robot: RobotSpec,
    program: Program,
    last: EngineState,
    last_s: float,
    hypothesis: Hypothesis,
    way: DarkWay,
    at: str = HERE,
) -> Resumption | Refused:
    """Return with what the mission goes on, or why it cannot.

    Args:
        robot: The robot.
        program: The program that was recorded.
        last: The engine's last recorded state.
        last_s: When that was, s.
        hypothesis: Where the robot is taken to be.
        way: How far it has driven since, as its wheels show or a person says.
        at: Where to go on: ``here``, ``failure`` or a phase, see :func:`entry`.
    """
    lost = {wheel.angle for wheel in robot.wheels} - way.seen
    if not way.exact:
        lost.add(robot.odometry)
    found = entry(robot, program, last, last_s, hypothesis.body, at, lost=lost)
    if isinstance(found, Refused):
        return found
    mission, distance = last.mission, last.sensing.distance
    return Resumption(
        found,
        hypothesis.body,
        mission.clock(last_s),
        mission.cause,
        mission.diverting.go_name if mission.diverting is not None else mission.handling,
        mission.paused or mission.pause_wanted,
        last.rules,
        odometry_m(robot, last.sensing, way),
        not way.exact and robot.odometry >= 0,
        distance._replace(width_m=distance.width_m + (way.high_m - way.low_m) / 2),
        mission.counts_from,
        mission.claim,
    )


# --- what it still depends on and nobody knows ------------------------------------------------


def unknowns(robot: RobotSpec, program: Program, table: VerdictTable) -> tuple[str, ...]:
    """Return the clamps and angles that the sensors do not show.

    A state that the command under way was to bring about is left out: it is given again at once.

    Args:
        robot: The robot.
        program: The program of the resumption.
        table: What the sensors have shown.
    """
    names = states_of(robot, table.hypothesis.body)
    goal = program.instructions[-1]
    under_way = goal.command if isinstance(goal, Do) else None
    return tuple(
        f"{each.about} {each.state}: {each.why}"
        for each in table.verdicts
        if each.word != "confirmed"
        and each.mark.command != under_way
        and (each.mark.kind == "part" or kind_of(robot, names, each.mark) == "angles")
    )


def position_read(robot: RobotSpec, program: Program, origin: Numbers) -> Iterator[tuple[int, str]]:
    """Yield the instructions from which the odometry is read, with the places of their conditions.

    A change of the odometry is read too if the value from which it counts is unknown.

    Args:
        robot: The robot.
        program: The program of the resumption.
        origin: The signals from which a wait counts that counts on.
    """
    if robot.odometry < 0:
        return
    name = robot.vocabulary.numbers[robot.odometry]
    changes = robot.vocabulary.with_changes.numbers
    change = changes[len(robot.vocabulary.numbers) + robot.odometry]
    lost = bool(origin) and isnan(origin[robot.odometry])
    for index in sorted(program.reached()):
        match program.instructions[index]:
            case Branch(condition=condition, place=place):
                if name in condition.names:
                    yield index, place
            case Wait(triggers=triggers, counts_on=counts_on, place=place):
                for each in triggers:
                    read = each.condition.names if each.condition is not None else ()
                    if name in read or (lost and counts_on and change in read):
                        yield index, each.place or place
            case _:
                pass
