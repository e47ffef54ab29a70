"""A rule about triggers: each can fire in time, and is not true from the beginning."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import replace

from pirate_sm.checking.exploring.conditions import Fact
from pirate_sm.checking.exploring.signal_ranges import signals, value
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.mission_view import MissionView
from pirate_sm.core.expressions import Expression, NumberType, Vocabulary, change_of, tree
from pirate_sm.core.program import Branch, Program, TriggerSpec, Wait
from pirate_sm.core.units import DIMENSIONLESS


def wait_triggers(view: MissionView) -> Iterator[Finding]:
    """Yield findings about triggers and about conditions of steps."""
    loaded, places = view.loaded, view.places
    judge = _Judge(view)
    reported: set[str] = set()
    if view.complete:
        for place, (code, message, fix) in judge.triggers().items():
            reported.add(place)
            yield places.finding(places.read(place), code, message, fix=fix)
    for place, condition, if_false in _conditions(loaded.program):
        said = judge.constant(condition)
        if said and place not in reported:
            message = f"'{condition.text}' is always {said}"
            fix = "leave the condition out" if said.startswith("true") else if_false
            yield places.finding(places.read(place), "condition.constant", message, fix=fix)
        for each in tree.walk(condition.tree):
            if isinstance(each, tree.Matches) and len({*each.words}) < len(each.words):
                twice = next(word for word in each.words if each.words.count(word) > 1)
                message = f"'{condition.text}' lists '{twice}' twice"
                yield places.finding(places.read(place), "condition.twice", message)
        for said in dict.fromkeys(_exact(condition.tree, loaded.robot.vocabulary.with_changes)):
            message = f"'{condition.text}' asks with {said}"
            yield places.finding(places.read(place), "condition.exact", message)


def _exact(node: tree.Node, vocabulary: Vocabulary) -> Iterator[str]:
    """Yield how a condition compares measured numbers for equality.

    At rest a sensor may show exactly 0, a bound of ``min`` and ``max`` is exact, and a number
    without a unit may be a flag or a count.
    """
    for each in tree.walk(node):
        if not isinstance(each, tree.Compare) or each.operator not in {"==", "!="}:
            continue
        sides = each.left, each.right
        zero = any(not signals(side) and value(side, 0.0) == 0.0 for side in sides)
        clipped = any(
            isinstance(part, tree.Call) and part.function != "abs" for part in tree.walk(each)
        )
        kinds = [vocabulary.types[name] for name in signals(each)]
        plain = all(isinstance(k, NumberType) and k.dimension == DIMENSIONLESS for k in kinds)
        if not (zero or clipped or plain):
            often = "almost never" if each.operator == "==" else "almost always"
            yield f"`{each.operator}` for a measured number, which is {often} true"


def _conditions(program: Program) -> Iterator[tuple[str, Expression, str]]:
    """Yield the place of each condition, the condition, and the fix if it is never true."""
    for each in program.instructions:
        if isinstance(each, Branch):
            yield each.place, each.condition, "leave the step out"
        elif isinstance(each, Wait):
            for trigger in each.triggers:
                if trigger.condition is not None:
                    yield trigger.place, trigger.condition, "leave the trigger out"


_Said = tuple[str, str, str]


class _Judge:
    def __init__(self, view: MissionView) -> None:
        loaded = view.loaded
        self._books, self._seen = view.explored, view.seen
        self._table, self._program = loaded.robot.table, loaded.program
        self._conditions = view.conditions
        self._changes = {change_of(name): name for name in loaded.robot.vocabulary.numbers}
        self._constant: dict[tree.Node, str] = {}

    def triggers(self) -> dict[str, _Said]:
        """Return the findings about triggers by place, without triggers that can be useful."""
        fine: set[str] = set()
        found: dict[str, _Said] = {}
        for wait in self._program.instructions:
            if not isinstance(wait, Wait):
                continue
            for number, trigger in enumerate(wait.triggers):
                said = self._trigger(wait, number, trigger)
                if said is None:
                    fine.add(trigger.place)
                else:
                    found.setdefault(trigger.place, said)
        idle = {
            trigger.place
            for wait in self._program.instructions
            if isinstance(wait, Wait)
            and any(found.get(each.place, ("",))[0] == "trigger.at_once" for each in wait.triggers)
            for trigger in wait.triggers
            if found.get(trigger.place, ("",))[0] == "trigger.shadowed"
        }
        return {place: said for place, said in found.items() if place not in fine | idle}

    def _trigger(self, wait: Wait, number: int, trigger: TriggerSpec) -> _Said | None:
        key = wait.phase, wait.place
        if not any(book.waits[key].armed for book in self._books):
            return None  # the unreachable phase is reported itself
        armed = sum(len(book.waits[key].armed) for book in self._seen)
        fired = sum(len(book.waits[key].fired[trigger.name]) for book in self._seen)
        if fired:
            at_once = sum(book.waits[key].at_once[trigger.name] for book in self._seen)
            if trigger.condition is None:
                return None
            blind = None if wait.counts_on else self._blind(wait, trigger, trigger.condition)
            if blind or not at_once:
                return blind
            if at_once == armed or not self._can_be(wait, [(trigger.condition.tree, False)]):
                message = f"'{trigger.text}' is true already whenever the wait begins"
                return "trigger.at_once", message, "go there without a wait"
            return None if wait.counts_on else self._unchanged(wait, trigger, trigger.condition)
        late = self._late(wait, trigger)
        if late:
            return "trigger.never", f"{late}: it can never fire", ""
        if trigger.condition is not None and not self._can_be(
            wait, [(trigger.condition.tree, True)]
        ):
            message = f"nothing can make '{trigger.condition.text}' true here"
            return "trigger.never", message, ""
        message = f"'{trigger.text}' can never fire: {self._ahead(wait, number)} always does"
        return "trigger.shadowed", message, "list it first, or leave it out"

    def _unchanged(self, wait: Wait, trigger: TriggerSpec, condition: Expression) -> _Said | None:
        """Return the finding about a condition that is true until something changes."""
        at_first = at_beginning(condition.tree, self._changes.keys())
        if at_first == condition.tree or self._can_be(wait, [(at_first, False)]):
            return None
        names = self._changed(condition)
        if not all(self._known_at_first(wait, names)):
            return None
        are = "is" if len(names) == 1 else "are"
        message = (
            f"'{trigger.text}' is true already whenever the wait begins and {' and '.join(names)} "
            f"{are} known: {' and '.join(map(change_of, names))} {are} 0 then"
        )
        fix = "ask for a change that the wait brings about: one backwards is negative"
        return "trigger.at_once", message, fix

    def _blind(self, wait: Wait, trigger: TriggerSpec, condition: Expression) -> _Said | None:
        """Return the finding about changes of signals that are unknown when the wait begins."""
        unknown = [
            name for name in self._changed(condition) if not any(self._known_at_first(wait, [name]))
        ]
        vocabulary = self._conditions.vocabulary
        facts = [(tree.Known(_signal(vocabulary, change_of(name))), False) for name in unknown]
        if not unknown or self._can_be(wait, [(condition.tree, True), *facts]):
            return None
        names = " and ".join(unknown)
        are = "is" if len(unknown) == 1 else "are"
        message = f"'{trigger.text}' can never fire: {names} {are} unknown when the wait begins"
        return "trigger.never", message, ""

    def _changed(self, condition: Expression) -> list[str]:
        """Return the distinct names of the signals whose changes the condition uses."""
        signals = (each for each in tree.walk(condition.tree) if isinstance(each, tree.Signal))
        names = dict.fromkeys(each.name for each in signals)
        return [self._changes[name] for name in names if name in self._changes]

    def _known_at_first(self, wait: Wait, names: Sequence[str]) -> Iterator[bool]:
        """Yield for each beginning of the wait whether these signals can be known then."""
        facts = [(tree.Known(_signal(self._conditions.vocabulary, name)), True) for name in names]
        for book in self._seen:
            for number in book.waits[wait.phase, wait.place].armed:
                step = book.found.steps[number]
                configuration = book.found.nodes[step.target].state.robot.configuration
                states = self._table.configurations[configuration]
                yield self._conditions.ask((*step.moment.facts, *facts), states).possible

    def _ahead(self, wait: Wait, number: int) -> str:
        """Return the trigger that fires before this one in every case."""
        own = wait.triggers[number].condition
        for trigger in wait.triggers[:number]:
            if own is None or trigger.condition is None:
                continue
            if not self._can_be(wait, [(own.tree, True), (trigger.condition.tree, False)]):
                return f"'{trigger.text}', listed before it,"
        return "another one"

    @staticmethod
    def _late(wait: Wait, trigger: TriggerSpec) -> str:
        """Return why the trigger comes only after the end of the wait; empty if it does not."""
        limits = [(wait.within_s, "`within`")]
        limits += [
            (each.after_s, f"'{each.text}'")
            for each in wait.triggers
            if each.after_s is not None and each is not trigger
        ]
        least_s, what = min(limits)
        own_s = trigger.held_s if trigger.after_s is None else trigger.after_s
        if own_s <= least_s:
            return ""
        took = "must be held for" if trigger.after_s is None else "comes after"
        return f"it {took} {own_s:g} s, and {what} ends the wait after {least_s:g} s"

    def _can_be(self, wait: Wait, facts: Sequence[Fact]) -> bool:
        """Return whether all facts can be true in a configuration of the wait."""
        reached = {
            self._table.configurations[configuration]
            for book in self._seen
            for configuration in book.waits[wait.phase, wait.place].states
        }
        return self._conditions.anywhere(facts, reached)

    def constant(self, condition: Expression) -> str:
        """Return ``true`` or ``false`` if the condition is constant, otherwise an empty text.

        A condition that is true for all known values of its signals counts as true; only
        :class:`~pirate_sm.core.expressions.tree.Known` should test whether they are known.
        """
        if condition.tree not in self._constant:
            every = self._table.configurations
            self._constant[condition.tree] = ""
            known = numbers_known(condition.tree)
            questions: list[tuple[str, list[Fact]]] = [
                ("true", [(condition.tree, False)]),
                ("false", [(condition.tree, True)]),
                ("true where its signals are known", [(condition.tree, False), *known]),
            ]
            for said, facts in questions:
                if not self._conditions.anywhere(facts, every):
                    self._constant[condition.tree] = said
                    break
        return self._constant[condition.tree]


def _signal(vocabulary: Vocabulary, name: str) -> tree.Signal:
    slot = vocabulary.slot(name)
    return tree.Signal(name, slot.kind, slot.index)


def numbers_known(node: tree.Node) -> list[Fact]:
    """Return the facts that the numeric signals are known whose values the condition uses."""
    parts = dict.fromkeys(tree.walk(node))
    if any(isinstance(each, tree.Known) for each in parts):
        return []
    numbers = (each for each in parts if isinstance(each, tree.Signal) and each.kind == "number")
    return [(tree.Known(each), True) for each in numbers]


def at_beginning(node: tree.Node, changes: Set[str]) -> tree.Node:
    """Return the condition with 0 for each change of a signal.

    A test whether a change is known is kept, because a signal may be unknown when the wait begins.

    Args:
        node: The condition, or a part of it.
        changes: Names of the changes, as :func:`~pirate_sm.core.expressions.change_of` gives
            them.
    """
    if isinstance(node, tree.Signal) and node.name in changes:
        return tree.Number(0.0)
    if isinstance(node, tree.Known):
        return node
    return _rebuilt(node, lambda each: at_beginning(each, changes))


def _rebuilt(node: tree.Node, change: Callable[[tree.Node], tree.Node]) -> tree.Node:
    """Return the node with a change of each node directly below it."""
    match node:
        case tree.Negate(operand) | tree.Not(operand):
            return replace(node, operand=change(operand))
        case tree.Arithmetic(_, left, right) | tree.Compare(_, left, right):
            return replace(node, left=change(left), right=change(right))
        case tree.Call(_, parts):
            return replace(node, arguments=tuple(map(change, parts)))
        case tree.And(parts) | tree.Or(parts):
            return replace(node, parts=tuple(map(change, parts)))
        case _:
            return node
