"""Resolve names in a mission: commands, phases, conditions, parameters, durations."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath

from pirate_sm.core._engine.mission.program import HERE, NEVER
from pirate_sm.core._engine.robot.robot_spec import USUAL, RobotSpec
from pirate_sm.core._expressions import (
    Expression,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_condition,
    compile_expression,
)
from pirate_sm.core._loading.mission.parameter_values import Value, Values
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.commands import constants_of
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core._model.mission import CONTINUE, FAIL, Mission
from pirate_sm.core._model.quantities import Parameter
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core._model.triggers import Trigger
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, TIME, Quantity, describe

_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
CAUSE, DRIVEN = "cause", "driven"
ROUND, ROUNDS = "round", "rounds"
_MEANINGS = {
    CAUSE: "why something failed",
    DRIVEN: "how far the robot has driven, as measured, with its bound",
    ROUND: "which round of a repeat this is",
    ROUNDS: "how many rounds a repeat has",
}
_UNCAUGHT = "'{}' cannot be caught: it always ends the run"


MOST_RETRIES = 100
"""Largest number of retries; the check explores each of them."""


class Label:
    """A jump target whose position may be set later."""

    __slots__ = ("index",)

    def __init__(self) -> None:
        self.index = -2


Handlers = tuple[tuple[str, Label | None, str, frozenset[str] | None, str], ...]
"""The fields of :class:`HandlerSpec`, with a label as the target."""


TIME_LIMIT = "within"
"""The trigger name of a wait's time limit."""


def labels_of(mission: Mission) -> dict[str, Label]:
    """Return a new label for each phase and end of a mission."""
    return {name: Label() for name in (*mission.phases, *mission.ends)}


def trigger_names(triggers: Sequence[Trigger]) -> list[str]:
    """Return a name for each trigger: its own, or its target with a number if that is taken."""
    names: list[str] = []
    for trigger in triggers:
        usual = trigger.go or CONTINUE
        name, again = trigger.name or usual, 2
        while name in names:
            name, again = f"{usual}_{again}", again + 1
        names.append(name)
    return names


@dataclass(frozen=True)
class Source:
    """A mission with its file and path."""

    mission: Mission
    document: Document
    path: FilePath


@dataclass(frozen=True)
class Scope:
    """One mission being compiled, with the meaning of all its names.

    Attributes:
        prefix: Prefix of its phases' names: empty, or ``phase/called.``.
        values: Values of its parameters.
        targets: Labels of its phases and ends.
        caller: Target of a failure that it does not handle itself.
        outer: Fault handlers of its callers.
        calls: Paths of the files being inlined, outermost first.
        phase: Name of the phase being compiled.
        inner: Target of a failure inside a step with its own ``on_failure``.
        turn: Round of the innermost repeat, from 1, and number of rounds; None outside repeats.
    """

    source: Source
    profile: Profile
    robot: RobotSpec
    problems: Problems
    prefix: str
    values: Values
    targets: Mapping[str, Label]
    caller: Label | int
    outer: Handlers
    calls: tuple[FilePath, ...]
    phase: str = ""
    inner: Label | int | None = None
    turn: tuple[int, int] | None = None

    @property
    def full_phase(self) -> str:
        """Return the phase's name, prefixed by those of the callers."""
        return f"{self.prefix}{self.phase}"

    def place(self, path: Path) -> str:
        """Return ``file:line:col`` of a part of the mission."""
        return str(self.source.document.place_of(path))

    def check_names(self) -> None:
        """Report ambiguous names, and a start that is not a phase."""
        mission, add = self.source.mission, self.problems.add
        for name in mission.ends:
            if name in mission.phases:
                add("mission.name", ("ends", name), f"'{name}' is a phase too", key=True)
        for section in ("phases", "ends"):
            for name in getattr(mission, section).keys() & {CONTINUE, FAIL}:
                message = f"'{name}' has a meaning of its own: choose another name"
                add("mission.name", (section, name), message, key=True)
        for name, meaning in _MEANINGS.items():
            if name in mission.parameters:
                message = f"'{{{name}}}' is {meaning}: choose another name"
                add("mission.name", ("parameters", name), message, key=True)
        if mission.start in mission.ends:
            add("mission.name", ("start",), f"'{mission.start}' is an end: start with a phase")

    def target(self, name: str, path: Path, *words: str) -> Label:
        """Return the label of a phase or end; report an unknown name, where `words` fit too."""
        label = self.targets.get(name)
        if label is None:
            self._unknown("phase or end", name, [*words, *self.targets], path)
            return Label()
        return label

    def failure(self, own: str | None, path: Path) -> Label | int:
        """Return the target of a failure: the nearest ``on_failure`` (rule 4).

        The phase that handles the mission's failures cannot handle its own.
        """
        mission = self.source.mission
        phase = mission.phases.get(self.phase)  # none at the head of a mission, for its control
        if own is not None:
            return self.target(own, (*path, "on_failure"), CONTINUE)
        if self.inner is not None:
            return self.inner
        if phase is not None and phase.on_failure is not None:
            at = ("phases", self.phase, "on_failure")
            if phase.on_failure == self.phase:
                self.problems.add("mission.loop", at, "a phase cannot handle its own failures")
            return self.target(phase.on_failure, at)
        if mission.on_failure is not None and mission.on_failure != self.phase:
            return self.target(mission.on_failure, ("on_failure",))
        return self.caller

    def resumed_at(self, wanted: str, path: Path) -> Label | str:
        """Return where the mission goes on after a crash in a phase; report an unknown phase."""
        if wanted in (HERE, NEVER):
            return wanted
        if wanted not in self.source.mission.phases:
            self._unknown("phase", wanted, self.source.mission.phases, path)
            return HERE
        return self.targets[wanted]

    @property
    def handles_failures(self) -> bool:
        """Return whether the phase or an enclosing step handles the failures of these steps."""
        phase = self.source.mission.phases[self.phase]
        return self.inner is not None or phase.on_failure is not None

    @property
    def handlers(self) -> Handlers:
        """Return the fault handlers in force: the mission's own, then those of its callers."""
        known = self.robot.fault_codes
        own: list[tuple[str, Label | None, str, frozenset[str] | None, str]] = []
        for number, handler in enumerate(self.source.mission.on_fault):
            path: Path = ("on_fault", number)
            go = self.target(handler.go, (*path, "go")) if handler.go else None
            for place, code in enumerate(handler.fault):
                at = (*path, "fault", place)
                if code not in known:
                    self._unknown_fault(code, known, at)
                elif not known[code]:
                    self.problems.add("mission.fault", at, _UNCAUGHT.format(code))
                of = self._owners(handler.of, code, (*path, "of"))
                name = f"{self.prefix}{handler.go}" if handler.go else ""
                own.append((code, go, name, of, self.place(at)))
        return (*own, *self.outer)

    def command(self, name: str, path: Path) -> int | None:
        """Return the index of a command or alias; None after reporting an unknown command.

        For further checks a misspelt command counts as the one that was most likely meant.
        """
        profile, table = self.profile, self.robot.table
        name = profile.aliases.get(name, name)
        if name in table.command_index:
            return table.command_index[name]
        if name in profile.not_commands:
            why = profile.not_commands[name]
            self.problems.add("mission.command", path, f"'{name}' is not a command: {why}")
            return None
        names = [*table.commands, *profile.aliases]
        self._unknown("command", name, names, path, "mission.command")
        meant = nearest(name, names)
        return None if meant is None else table.command_index[profile.aliases.get(meant, meant)]

    def control(self, name: str, path: Path) -> int:
        """Return the index of a control, 0 for ``none``; 0 too after reporting an unknown one."""
        names = [each.name for each in self.robot.controls[1:]]
        if name in names:
            return names.index(name) + 1
        if name != USUAL:
            self._unknown("control", name, [*names, USUAL], path, "mission.control")
        return 0

    def condition(self, text: str, path: Path, *, in_wait: bool = False) -> Expression | None:
        """Return the compiled condition, or None after reporting its faults.

        Args:
            text: The condition.
            path: Its path in the file.
            in_wait: Whether it may use the change of a signal since the wait began.
        """
        vocabulary = self.robot.vocabulary
        try:
            return compile_condition(
                text, vocabulary.with_changes if in_wait else vocabulary, self._constants
            )
        except ExpressionError as error:
            self.problems.add_expression(path, error)
            return None

    def bound_m(self, text: str, path: Path) -> float:
        """Return the length after the words ``known within``, m; 0 after reporting a fault."""
        try:
            found = compile_expression(text, Vocabulary({}), self._constants)
        except ExpressionError as error:
            self.problems.add_expression(path, error)
            return 0.0
        if found.type != NumberType(LENGTH):
            message = f"'{text.strip()}' is {found.type}"
            self.problems.add("expression", path, message, expected="a length")
            return 0.0
        return found.evaluate((), ()) or 0.0

    def waited(self, value: float | Parameter, path: Path, *, zero: bool = False) -> float:
        """Return a time in s; report a time below one bus cycle, in which no sensor reports.

        Args:
            value: The time as in the file, or a parameter.
            path: Its path in the file.
            zero: Whether 0, no waiting at all, is allowed too.
        """
        seconds = value if not isinstance(value, Parameter) else self._seconds(value, path)
        least_s = self.profile.link.cycle
        if seconds < least_s and not (zero and seconds == 0):
            least = f"at least {1e3 * least_s:g} ms, one cycle of the robot's bus"
            got = f"{1e3 * seconds:g} ms" if abs(seconds) < 1 else f"{seconds:g} s"
            expected = f"expected {least}{', or 0 s' if zero else ''}, got {got}"
            self.problems.add("mission.time", path, expected)
        return seconds

    def limit(self, value: float | Parameter | None, path: Path) -> float | None:
        """Return a time limit in s, at least one bus cycle; None without a limit."""
        return None if value is None else self.waited(value, path)

    def _seconds(self, parameter: Parameter, path: Path) -> float:
        quantity = self._value(parameter.name, path).quantity
        if quantity.dimension != TIME:
            kind = describe(quantity.dimension)
            self.problems.add(
                "mission.parameter", path, f"${parameter.name} is {kind}", expected="a duration"
            )
        return abs(quantity.value) if quantity.dimension != TIME else quantity.value

    def count(self, value: int | Parameter, path: Path) -> int:
        """Return an integer, given as a number or as a parameter."""
        if not isinstance(value, Parameter):
            return value
        quantity = self._value(value.name, path).quantity
        number = quantity.value
        if quantity.dimension != DIMENSIONLESS or number < 0 or number != int(number):
            self.problems.add(
                "mission.parameter", path, f"${value.name} is no count", expected="a whole number"
            )
            return 1
        return int(number)

    def retries(self, value: int | Parameter, path: Path) -> int:
        """Return the number of retries of a command; report a number that is too large."""
        number = self.count(value, path)
        if number <= MOST_RETRIES:
            return number
        message = f"expected a count of at most {MOST_RETRIES}, got {number}"
        self.problems.add("range", path, message)
        return 0

    def message(self, text: str, path: Path) -> str:
        """Return the text with the values of parameters and rounds.

        What is known only in a run, ``{cause}`` and ``{driven}``, is kept.
        """
        shown = {name: value.text for name, value in self.values.items()}
        if self.turn is not None:
            shown |= {ROUND: str(self.turn[0]), ROUNDS: str(self.turn[1])}
        known = [*self.source.mission.parameters, CAUSE, DRIVEN]
        for name in _FIELD.findall(text):
            if name in (ROUND, ROUNDS) and self.turn is None:
                message = f"'{{{name}}}' is {_MEANINGS[name]}, and there is no repeat around this"
                self.problems.add("mission.name", path, message)
            elif name not in known and name not in shown:
                self._unknown("parameter", name, known, path)
        return _FIELD.sub(lambda match: shown.get(match.group(1), match.group(0)), text)

    def argument(self, value: str | float, path: Path) -> Value | str | float:
        """Return an argument of a call; ``$name`` is the value of the caller's parameter."""
        if isinstance(value, str) and value.startswith("$"):
            return self._value(value[1:], path)
        return value

    @property
    def _constants(self) -> dict[str, Quantity]:
        given = {name: value.quantity for name, value in self.values.items()}
        return constants_of(self.profile) | given

    def _value(self, name: str, path: Path) -> Value:
        if name in self.values:
            return self.values[name]
        self._unknown("parameter", name, self.source.mission.parameters, path)
        return Value(Quantity(1.0, TIME), "")

    def _owners(self, names: Sequence[str], code: str, path: Path) -> frozenset[str] | None:
        """Return what a line's `of` names; report names that a fault with the code cannot be of."""
        if not names:
            return None
        owners, can_be = self.robot.owners, self.robot.possible_owners.get(code, frozenset())
        for place, name in enumerate(names):
            at = (*path, place)
            if name not in owners.things:
                self._unknown("board, joint, wheel or part", name, owners.things, at)
            elif code in self.robot.fault_codes and not owners.things[name] & can_be:
                expected = one_of(sorted(can_be)) if can_be else "no `of`: it is nobody's"
                message = f"'{code}' cannot be a fault of {name}"
                self.problems.add("mission.fault", at, message, expected=expected)
        return owners.things_of(names)

    def _unknown_fault(self, code: str, known: Mapping[str, bool], path: Path) -> None:
        """Report an unknown fault, and list the faults that a mission may handle."""
        close = nearest(code, known)
        if close and not known[close]:
            message = f"there is no fault '{code}', and {_UNCAUGHT.format(close)}"
            self.problems.add("mission.name", path, message)
        else:
            self._unknown("fault", code, [each for each in known if known[each]], path)

    def _unknown(
        self, kind: str, name: str, known: object, path: Path, code: str = "mission.name"
    ) -> None:
        names = list(known)  # type: ignore[call-overload]
        self.problems.add_unknown(code, path, kind, name, names, none=f"no {kind} at all")
