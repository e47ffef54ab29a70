"""Triggers that nothing can make true, that come too late, or that are true already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.ledger import Ledger
from pirate_sm.checking.exploring.ranges import ranges
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.places import Places
from pirate_sm.engine.program import Branch, TriggerSpec, Wait
from pirate_sm.expressions import Expression, tree
from pirate_sm.loading.mission import LoadedMission


def wait_findings(
    books: Sequence[Ledger], loaded: LoadedMission, places: Places
) -> Iterator[Finding]:
    """What is wrong with triggers and with conditions of steps."""
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    judge = _Judge(
        books, loaded, Conditions(loaded.robot.vocabulary, spans, len(loaded.robot.regions))
    )
    if all(book.found.complete for book in books):
        for place, (code, severity, message, mend) in judge.triggers().items():
            yield places.finding(places.read(place), code, severity, message, mend=mend)
    for each in loaded.program.instructions:
        if isinstance(each, Branch):
            said = judge.constant(each.condition)
            if said:
                yield places.finding(
                    places.read(each.place), "condition.constant", Severity.WARNING,
                    f"'{each.condition.text}' is always {said}",
                    mend="leave the condition out" if said == "true" else "leave the step out",
                )  # fmt: skip


_Said = tuple[str, Severity, str, str]


class _Judge:
    def __init__(
        self, books: Sequence[Ledger], loaded: LoadedMission, conditions: Conditions
    ) -> None:
        self._books = books
        self._table = loaded.robot.table
        self._program = loaded.program
        self._conditions = conditions
        self._constant: dict[tree.Node, str] = {}

    def triggers(self) -> dict[str, _Said]:
        """What is to be said of a trigger, by its place; nothing where it is ever of use."""
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
        return {place: said for place, said in found.items() if place not in fine}

    def _trigger(self, wait: Wait, number: int, trigger: TriggerSpec) -> _Said | None:
        armed = sum(len(book.waits[wait.phase].armed) for book in self._books)
        if not armed:
            return None  # that its phase is never reached is said there
        fired = sum(len(book.waits[wait.phase].fired[trigger.name]) for book in self._books)
        if fired:
            at_once = sum(book.waits[wait.phase].at_once[trigger.name] for book in self._books)
            if at_once < armed or trigger.condition is None:
                return None
            message = f"'{trigger.text}' is true already whenever the wait begins"
            return "trigger.at_once", Severity.WARNING, message, "go there without a wait"
        late = self._late(wait, trigger)
        if late:
            return "trigger.never", Severity.ERROR, f"{late}: it can never fire", ""
        if trigger.condition is not None and not self._can_hold(wait, trigger.condition):
            message = f"nothing can make '{trigger.condition.text}' true here"
            return "trigger.never", Severity.ERROR, message, ""
        earlier = wait.triggers[number - 1].text if number else "another"
        message = f"'{trigger.text}' can never fire: '{earlier}', listed before it, always does"
        return "trigger.shadowed", Severity.WARNING, message, "list it first, or leave it out"

    @staticmethod
    def _late(wait: Wait, trigger: TriggerSpec) -> str:
        """Why the trigger would come only after the wait is over; empty: it need not."""
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

    def _can_hold(self, wait: Wait, condition: Expression) -> bool:
        reached = {
            configuration for book in self._books for configuration in book.waits[wait.phase].states
        }
        return any(
            self._conditions.ask(
                [(condition.tree, True)], self._table.configurations[each]
            ).possible
            for each in reached
        )

    def constant(self, condition: Expression) -> str:
        """``true`` or ``false`` where the condition is that in every configuration."""
        if condition.tree not in self._constant:
            regions = self._conditions.regions(condition.tree)
            every = {
                tuple(state if n in regions else None for n, state in enumerate(states))
                for states in self._table.configurations
            }
            self._constant[condition.tree] = ""
            for fact, said in ((False, "true"), (True, "false")):
                asked = [(condition.tree, fact)]
                if not any(self._conditions.ask(asked, states).possible for states in every):
                    self._constant[condition.tree] = said
        return self._constant[condition.tree]
