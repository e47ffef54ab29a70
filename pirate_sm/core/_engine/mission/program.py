"""A mission as the interpreter runs it: a flat list of instructions, targets resolved to indexes.

Calls are inlined and repeats unrolled (:mod:`pirate_sm.core._loading.mission.program`), so a
program has no variables and no stack. The program counter alone gives its position, and a checker
can follow every path: :meth:`Program.successors`. :func:`signals_read` says by what it decides
anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf, isnan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._engine.robot.actuation_spec import GripSpec
from pirate_sm.core._engine.robot.criteria import needs_of_signals
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._expressions import Expression

MOST_PHASES = 1_000
"""Limit of phases begun within one second of mission time [decided]. At a bus cycle of 10 ms at
most 100 waits can end in a second; a mission that begins more phases runs in a circle."""

STOP = -1
"""A failure's target when nothing handles it: the safe stop, mission failed."""


HERE, NEVER = "here", "never"
"""What a phase says about going on in it after a crash, if it names no other phase."""


DRIVEN = "{driven}"
"""Where a text names the distance that was driven, as measured."""


BranchKind: TypeAlias = Literal[
    "trigger", "within", "if", "else", "choice", "on_failure", "retry", "on_fault", "resume"
]
"""The kinds of branches of a mission: each way on from a place where there is more than one."""


class BranchKey(NamedTuple):
    """Identifies a branch.

    Attributes:
        kind: ``else`` is the way past a condition, also where the file has no such word.
        place: Where it stands, ``file:line:col``: the trigger, the wait of a ``within``, the
            condition, the step that fails or asks, the fault, or the phase that is taken up.
        name: The trigger, the choice or the code of the fault; empty for other kinds.
    """

    kind: BranchKind
    place: str
    name: str = ""


class Enter(NamedTuple):
    """Begins a phase.

    Attributes:
        failed: Where a failure in the phase leads.
        resume: Where the mission goes on if its run is cut off in the phase: ``here``, ``never``,
            or the index of the instruction that enters another phase.
        place: Where it stands, ``file:line:col``.
    """

    phase: str
    next: int
    failed: int = STOP
    resume: int | Literal["here", "never"] = "here"
    place: str = ""


class Do(NamedTuple):
    """Gives a command and waits until it is done.

    Attributes:
        timeout_s: Overrides the robot's own timeout; None for the robot's.
        retries: How often the command is repeated after a failure.
        skip_unneeded: Whether an unneeded command counts as done.
        failed: Target of a failure. ``expected``: the step itself names it. ``handled``: its phase
            or an enclosing step does.
        place: Where it stands, ``file:line:col``.
    """

    command: int
    timeout_s: float | None
    retries: int
    skip_unneeded: bool
    next: int
    failed: int
    place: str
    expected: bool = False
    handled: bool = False


class SwitchControl(NamedTuple):
    """Actuates the robot's states by another control, and awaits the torques of its joints.

    Attributes:
        control: Index of the control among the robot's.
        timeout_s: How long the joints may take to bear their torques.
        failed: Where a failure leads; ``place``: where it stands, ``file:line:col``.
    """

    control: int
    timeout_s: float
    next: int
    failed: int
    place: str


class Branch(NamedTuple):
    """Branches on a condition; an unknown condition takes the false branch with a warning."""

    condition: Expression
    if_true: int
    if_false: int
    place: str


class Require(NamedTuple):
    """Fails unless the robot is confirmed to be in these states: (region, state name).

    ``expected`` and ``handled`` are those of :class:`Do`; ``call`` is the mission that is called
    in these states, empty if none is.
    """

    states: tuple[tuple[int, str], ...]
    what: str
    next: int
    failed: int
    place: str
    expected: bool = False
    handled: bool = False
    call: str = ""


class TriggerSpec(NamedTuple):
    """A trigger of a wait; exactly one of ``condition``, ``after_s`` and ``answer`` is given.

    Attributes:
        condition: Fires when this has been true for ``held_s``.
        after_s: Seconds since the wait was armed.
        answer: The answer of the operator.
        known_within_m: The bound within which the distance must be known.
        place: Where it stands, ``file:line:col``.
    """

    name: str
    text: str
    go: int
    go_name: str
    condition: Expression | None = None
    held_s: float = 0.0
    after_s: float | None = None
    answer: str = ""
    place: str = ""
    known_within_m: float = inf


class Wait(NamedTuple):
    """Waits for one of the triggers, at most ``within_s``.

    Attributes:
        within: Target after the time limit. ``fails``: whether that is a failure of the step.
        compares: Whether a condition uses the change of a signal since the wait began.
        counts_on: Whether changes count from where the last wait counted them.
    """

    phase: str
    triggers: tuple[TriggerSpec, ...]
    within_s: float
    within: int
    within_name: str
    place: str
    compares: bool = False
    fails: bool = False
    counts_on: bool = False


class Question(NamedTuple):
    """Asks the operator; each choice leads to its own target."""

    text: str
    choices: tuple[tuple[str, int], ...]
    timeout_s: float
    failed: int
    place: str


class Say(NamedTuple):
    """Logs a line; ``place`` is empty for the result of a called mission."""

    level: Literal["info", "warning"]
    message: str
    next: int
    place: str = ""


class Raise(NamedTuple):
    """Ends an inlined mission, or an answer, with a failure."""

    message: str
    failed: int
    place: str


class Finish(NamedTuple):
    """Ends the mission."""

    outcome: Literal["succeeded", "failed"]
    message: str
    end: str
    place: str = ""


Instruction: TypeAlias = (
    Enter | Do | SwitchControl | Branch | Require | Wait | Question | Say | Raise | Finish
)


class RuleSpec(NamedTuple):
    """A safety rule in force for this mission; :mod:`~pirate_sm.core._engine.safety` judge.

    Attributes:
        after: The rule applies once this has been true; None: always.
        must: The condition that must hold then.
        within: How many commands may be accepted until it holds; None: it must hold at all times.
        why: What happens if it is broken.
        waived_by: Key with which a mission may waive the rule; empty: no mission may.
    """

    name: str
    text: str
    after: Expression | None
    must: Expression
    within: int | None
    why: str = ""
    waived_by: str = ""


class HandlerSpec(NamedTuple):
    """The handling of a fault: the target ``go``, or None to only log the fault.

    Attributes:
        of: The joints, wheels and boards of which it handles the fault; None: everybody's, and
            nobody's.
        place: Where its fault stands, ``file:line:col``.
    """

    code: str
    go: int | None
    go_name: str
    of: frozenset[str] | None = None
    place: str = ""

    def handles(self, code: str, things: frozenset[str]) -> bool:
        """Return whether it handles a fault that concerns exactly these things."""
        return self.code == code and (self.of is None or (bool(things) and things <= self.of))


@dataclass(frozen=True)
class Program:
    """A whole mission.

    Attributes:
        start: Index of the first instruction.
        start_configuration: Index of the configuration in which the robot must start.
        handlers: Per instruction the fault handlers in force, innermost first.
        phases: Phase names in the order of the file; inlined phases are ``caller/callee``.
        phase_of: Per instruction the name of its phase.
        time_limit_s: Longest duration of the run; infinite without a limit.
        diameter_m: Inner diameter of the pipe where the robot starts; None where it is unknown.
        bores_m: All inner diameters of its route, that of the start first; empty where unknown.
        rules: The robot's safety rules, without those that the mission waives.
        most_phases: How many phases may begin within one second of mission time.
        turn_of: Per instruction the round of its repeat, such as ``2 of 4``, or empty.
        entries: Per phase the controls under which the mission comes there, each with the index of
            the instruction that sets it before it enters the phase; empty without controls.
    """

    instructions: tuple[Instruction, ...]
    start: int
    start_configuration: int
    handlers: tuple[tuple[HandlerSpec, ...], ...]
    phases: tuple[str, ...]
    phase_of: tuple[str, ...]
    time_limit_s: float
    rules: tuple[RuleSpec, ...] = ()
    diameter_m: float | None = None
    bores_m: tuple[float, ...] = ()
    most_phases: float = MOST_PHASES
    turn_of: tuple[str, ...] = ()
    entries: Mapping[str, tuple[tuple[int, int], ...]] = field(default_factory=dict)

    def round_note(self, at: int) -> str:
        """Return an instruction's round of a repeat as `` (2 of 4)``; empty outside repeats."""
        turn = self.turn_of[at] if at < len(self.turn_of) else ""
        return f" ({turn})" if turn else ""

    def entered(self, at: int) -> Enter:
        """Return the instruction that enters the phase of an instruction."""
        home = self.phase_of[at]
        inside = (
            self.instructions[each] for each in range(at, -1, -1) if self.phase_of[each] == home
        )
        found = next((each for each in inside if isinstance(each, Enter)), None)
        return found or Enter(home, at)

    def enter(self, phase: str) -> int | None:
        """Return the index of the instruction that enters a phase, None where there is none."""
        for index, (each, home) in enumerate(zip(self.instructions, self.phase_of, strict=True)):
            if home == phase and isinstance(each, Enter):
                return index
        return None

    def beginning(self, phase: str, control: int = 0) -> int | None:
        """Return the index of the instruction that takes the mission up at a phase.

        Args:
            phase: The phase; None is returned if there is no such phase.
            control: The control in force. One that is not the usual control stays if the mission
                itself may come to the phase under it. Otherwise the entry sets the one under which
                the mission comes there, by the shortest way if there are several.
        """
        entries = dict(self.entries.get(phase, ()))
        wanted = control if control and control in entries else next(iter(entries), 0)
        return entries[wanted] if entries and (control or wanted) else self.enter(phase)

    @property
    def goes_on(self) -> bool:
        """Whether it starts within a phase, as the program of a run that was cut off does."""
        return self.start != self.enter(self.phase_of[self.start])

    @property
    def taken_up(self) -> str:
        """Return the place of the phase in which it starts, ``file:line:col``."""
        at = self.enter(self.phase_of[self.start])
        return getattr(self.instructions[at], "place", "") if at is not None else ""

    def handler(self, at: int, code: str, things: frozenset[str]) -> HandlerSpec | None:
        """Return the innermost handler at this instruction for a fault that concerns these."""
        if not 0 <= at < len(self.handlers):
            return None
        return next((each for each in self.handlers[at] if each.handles(code, things)), None)

    def successors(self, at: int, *, fires: bool = True) -> Iterator[int]:
        """Yield the targets of an instruction: those of success, of failures, of fault handlers.

        Args:
            at: Index of the instruction.
            fires: Whether a trigger of a wait may fire.
        """
        yield from self.successes(at, fires=fires)
        yield from self.failures(at)

    def successes(self, at: int, *, fires: bool = True) -> Iterator[int]:
        """Yield where an instruction leads that does not fail; of a wait only if a trigger may."""
        match self.instructions[at]:
            case (Enter() | Say() | Do() | SwitchControl() | Require()) as it:
                yield it.next
            case Branch() as it:
                yield from (it.if_true, it.if_false)
            case Wait() as it if fires:
                yield from (each.go for each in it.triggers)
            case Question() as it:
                yield from (target for _, target in it.choices)
            case Wait() | Raise() | Finish():
                pass

    def failures(self, at: int) -> Iterator[int]:
        """Yield where a failure, a time limit and fault handlers lead from an instruction."""
        it = self.instructions[at]
        if isinstance(it, Wait):
            yield it.within
        elif not isinstance(it, Enter | Say | Branch | Finish):
            yield it.failed
        yield from (each.go for each in self.handlers[at] if each.go is not None)

    def reached(self, *, without: int | None = None) -> set[int]:
        """Return the instructions to which a way leads from the start.

        Args:
            without: A wait of which no trigger fires.
        """
        found, pending = {self.start}, [self.start]
        while pending:
            at = pending.pop()
            for target in self.successors(at, fires=at != without):
                if target >= 0 and target not in found:
                    found.add(target)
                    pending.append(target)
        return found


# --- by which signals it decides anything -----------------------------------------------------


_WITH_TEXT = (Finish, Raise, Say)


def signals_read(robot: RobotSpec, program: Program) -> frozenset[int]:
    """Return the number indexes of signals in conditions, texts, fault rules, criteria and grips.

    Grips count that estimate the friction, which takes many rounds, where the mission uses their
    control; each run begins with the usual one. Grips that know the friction read slip while their
    control is in force, see :func:`slip_watched`.
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
    needs = (need for done in criteria for need in needs_of_signals(done, len(robot.slots)))
    return frozenset(bound.signal for need in needs for way in need.ways for bound in way)


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
