"""Compare what two versions of a mission can do, independently of their texts."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, TypeVar

from pirate_sm.checking.exploring.exploration import WITHIN
from pirate_sm.checking.mission_behaviour import (
    IGNORED,
    STOPPED,
    Abilities,
    PossibleEnd,
    Success,
    Trigger,
    in_new_names,
    matched_triggers,
    renamed,
)
from pirate_sm.checking.reports.text import count

K = TypeVar("K")
V = TypeVar("V")

Kind: TypeAlias = Literal["gained", "lost", "changed", "renamed"]
About: TypeAlias = Literal[
    "fact", "phase", "command", "trigger", "outcome", "failure", "fault", "rule", "success"
]


@dataclass(frozen=True)
class BehaviourChange:
    """One difference in behaviour.

    Attributes:
        text: The difference as a sentence.
        phase: The phase, by its new name; empty if the difference is not in one phase.
        name: Name of the part that differs.
        before: The old behaviour; ``after``: the new one. Empty if there is none.
    """

    kind: Kind
    about: About
    text: str
    name: str = ""
    phase: str = ""
    before: str = ""
    after: str = ""


@dataclass(frozen=True)
class MissionDifference:
    """All differences between two versions.

    Attributes:
        cut_off: Versions that were too large to explore; there may be more differences.
    """

    changes: tuple[BehaviourChange, ...]
    cut_off: tuple[Literal["old", "new"], ...] = ()

    @property
    def same(self) -> bool:
        """Return whether no difference is known."""
        return all(each.kind == "renamed" for each in self.changes)

    def of(self, kind: Kind) -> tuple[BehaviourChange, ...]:
        """Return the changes of one kind."""
        return tuple(each for each in self.changes if each.kind == kind)


def compare(old: Abilities, new: Abilities) -> MissionDifference:
    """Return the differences in behaviour between the old and the new version.

    A phase or an end that differs only in its name counts as renamed.
    """
    phases, ends = renamed(old.phases, new.phases), renamed(old.outcomes, new.outcomes)
    renamings = [
        *(_renaming("phase", before, after) for before, after in phases.items()),
        *(_renaming("outcome", before, after) for before, after in ends.items()),
    ]
    was = in_new_names(old, {**ends, **phases})
    changes = [
        *_facts(was, new),
        *_phases(was, new),
        *_commands(was, new),
        *_triggers(was, new),
        *_outcomes(was, new),
        *_failures(was, new),
        *_faults(was, new),
        *_rules(was, new),
        *_success(was.success, new.success),
        *renamings,
    ]
    cut_off: list[Literal["old", "new"]] = ["old"] if not old.complete else []
    return MissionDifference(tuple(changes), tuple(cut_off + (["new"] if not new.complete else [])))


def _renaming(about: About, before: str, after: str) -> BehaviourChange:
    thing = "phase" if about == "phase" else "end"
    text = f"the {thing} '{before}' is called '{after}' now"
    return BehaviourChange("renamed", about, text, after, "", before, after)


def _facts(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    for name, after in new.facts.items():
        before = old.facts.get(name, after)
        if before != after:
            text = f"{name}: {after}; before: {before}"
            yield BehaviourChange("changed", "fact", text, name, "", before, after)


def _phases(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    for kind, name, here, there in _one_sided(old, new, lambda each: each.phases):
        gives = [command for phase, command in here.commands if phase == name]
        elsewhere = {command for _, command in there.commands}
        alone = ", ".join(command for command in gives if command not in elsewhere)
        gained = kind == "gained"
        text = f"the phase '{name}' " + ("can be reached" if gained else "can no longer be reached")
        if gives:
            text += f"; it {'gives' if gained else 'gave'} {', '.join(gives)}"
        if alone:
            text += f"; before, nothing gave {alone}" if gained else f"; now nothing gives {alone}"
        yield BehaviourChange(kind, "phase", text, name)


def _commands(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    for kind, (phase, name), _, there in _one_sided(old, new, lambda each: each.commands):
        if phase not in there.phases:
            continue  # reported with the phase
        nowhere = all(other != name for _, other in there.commands)
        if kind == "gained":
            text = f"{name} can be given in '{phase}'" + "; before, nothing gave it" * nowhere
        else:
            text = f"{name} is no longer given in '{phase}'" + "; now nothing gives it" * nowhere
        yield BehaviourChange(kind, "command", text, name, phase)
    for (phase, name), before, after in _both(old.commands, new.commands):
        text = f"{name} in '{phase}' is given on other terms: {after}; before: {before}"
        yield BehaviourChange("changed", "command", text, name, phase, before, after)


def _triggers(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    old = replace(old, triggers=matched_triggers(old.triggers, new.triggers))
    for kind, (phase, name), here, there in _one_sided(old, new, lambda each: each.triggers):
        if phase not in there.phases:
            continue
        said = _trigger_words(name, here.triggers[phase, name])
        text = f"the wait of '{phase}' can end by {said}"
        if kind == "lost":
            text = f"the wait of '{phase}' no longer ends by {said}"
        yield BehaviourChange(kind, "trigger", text, name, phase)
    for (phase, name), was, now in _both(old.triggers, new.triggers):
        before, after = _trigger_words(name, was), _trigger_words(name, now)
        text = f"the wait of '{phase}' ends by {after}; before by {before}"
        what = _cause(name, now)
        if was.go == now.go:
            text = f"the wait of '{phase}' ends by {what}; before by {_cause(name, was)}"
        elif was.text == now.text:
            leads = _quoted(now.go)
            text = f"in '{phase}' {what} leads to {leads}; before to {_quoted(was.go)}"
        yield BehaviourChange("changed", "trigger", text, name, phase, before, after)


def _outcomes(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    for kind, name, here, _ in _one_sided(old, new, lambda each: each.outcomes):
        said = f", which {_outcome_words(here.outcomes[name])}"
        if name == STOPPED:
            said = ", as nothing handles a failure or a fault"
        text = f"it can end in {_end_words(name)}{said}"
        if kind == "lost":
            text = f"it no longer ends in {_end_words(name)}{said}"
        yield BehaviourChange(kind, "outcome", text, name)
    for name, was, now in _both(old.outcomes, new.outcomes):
        before, after = _outcome_words(was), _outcome_words(now)
        text = f"the end '{name}' {after}; before: {before}"
        yield BehaviourChange("changed", "outcome", text, name, "", before, after)


def _failures(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    """Yield commands whose failure leads to other ends, grouped by equal changes."""
    alike: dict[tuple[str, str], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for (phase, name), was, now in _both(old.failures, new.failures):
        alike[_names_of_ends(was), _names_of_ends(now)][phase].append(name)
    for (before, after), phases in alike.items():
        for phase, names in phases.items():
            text = (
                f"where {' or '.join(names)} fails in '{phase}' and nothing else goes wrong, "
                f"it ends in {after}; before in {before}"
            )
            yield BehaviourChange(
                "changed", "failure", text, ", ".join(names), phase, before, after
            )


def _faults(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    """Yield faults with another target, with phases grouped by equal changes."""
    kept = [phase for phase in new.phases if phase in old.phases]
    codes = dict.fromkeys(code for _, code in (*old.faults, *new.faults))
    for code in codes:
        alike: dict[tuple[str, str], list[str]] = defaultdict(list)
        for phase in kept:
            before, after = old.faults.get((phase, code), ""), new.faults.get((phase, code), "")
            if before != after:
                alike[before, after].append(phase)
        for (before, after), phases in alike.items():
            where = "" if len(phases) == len(kept) else f" in {_quoted(phases)}"
            text = f"the fault {code} {_handling(after)}{where}; before: {_handling(before)}"
            kind: Kind = "changed" if before and after else "gained" if after else "lost"
            yield BehaviourChange(
                kind, "fault", text, code, ", ".join(phases) * bool(where), before, after
            )


def _rules(old: Abilities, new: Abilities) -> Iterator[BehaviourChange]:
    for kind, message, _, _ in _one_sided(old, new, lambda each: _in_order(each.broken)):
        text = f"it can come to this: {message}"
        if kind == "lost":
            text = f"it no longer comes to this: {message}"
        yield BehaviourChange(kind, "rule", text, message)
    for kind, name, _, _ in _one_sided(old, new, lambda each: _in_order(each.rules)):
        text = f"the rule {name} is {'no longer ' * (kind == 'lost')}watched"
        yield BehaviourChange(kind, "rule", text, name)


def _in_order(names: Iterable[str]) -> Mapping[str, None]:
    """Return the names as keys, in a reproducible order."""
    return dict.fromkeys(sorted(names))


def _success(old: Success | None, new: Success | None) -> Iterator[BehaviourChange]:
    if old == new:
        return
    before, after = (_way_words(each) if each else "" for each in (old, new))
    if old is None or new is None:
        kind: Kind = "lost" if new is None else "gained"
        text = "nothing leads to success any more" if new is None else "it can succeed"
    else:
        kind, text = "changed", f"success takes at least {after}; before {before}"
    yield BehaviourChange(kind, "success", text, "", "", before, after)


def _one_sided(
    old: Abilities, new: Abilities, part: Callable[[Abilities], Mapping[K, object]]
) -> Iterator[tuple[Kind, K, Abilities, Abilities]]:
    """Yield parts of one version only: gained or lost, key, the version with it, the other."""
    before, after = part(old), part(new)
    yield from (("gained", key, new, old) for key in after if key not in before)
    yield from (("lost", key, old, new) for key in before if key not in after)


def _both(old: Mapping[K, V], new: Mapping[K, V]) -> Iterator[tuple[K, V, V]]:
    """Yield the keys that both have with different values."""
    return ((key, old[key], new[key]) for key in new if key in old and old[key] != new[key])


def _trigger_words(name: str, trigger: Trigger) -> str:
    """Return what ends a wait, and its target."""
    return f"{_cause(name, trigger)}, which leads to {_quoted(trigger.go)}"


def _cause(name: str, trigger: Trigger) -> str:
    """Return what ends a wait."""
    return f"its limit of {trigger.text}" if name == WITHIN else f"'{trigger.text}'"


def _outcome_words(outcome: PossibleEnd) -> str:
    """Return whether an end succeeds, with its message."""
    said = f": {outcome.message}" if outcome.message else ""
    return ("succeeds" if outcome.succeeds else "fails") + said


def _end_words(name: str) -> str:
    """Return the name of an end."""
    return "the safe stop" if name == STOPPED else f"'{name}'"


def _names_of_ends(names: frozenset[str]) -> str:
    """Return the names of ends."""
    return " or ".join(map(_end_words, sorted(names))) or "nothing: it goes round forever"


def _handling(go: str) -> str:
    """Return the handling of a fault."""
    if not go:
        return "stops the mission"
    return "is only told" if go == IGNORED else f"leads to '{go}'"


def _way_words(way: Success) -> str:
    """Return the number of commands and events on a path to success."""
    return f"{count(way.commands, 'command')} and {count(way.events, 'event')}"


def _quoted(names: Iterable[str]) -> str:
    """Return names in quotes, separated by commas."""
    return ", ".join(f"'{name}'" for name in names)
