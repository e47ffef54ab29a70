"""The possible behaviour of a mission, and which parts of it were only renamed.

It is derived from an exploration of everything that can happen, so steps that are never reached
are not part of it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

STOPPED = "(safe stop)"
"""Name of the safe stop after an unhandled failure or fault; no end can have this name."""

IGNORED = "(go on)"
"""Instead of a fault's target phase: the mission continues after the fault."""


class Trigger(NamedTuple):
    """A trigger of a wait.

    Attributes:
        text: The condition as text.
        go: Its targets; several if a call is repeated with other values.
    """

    text: str
    go: tuple[str, ...]


class PossibleEnd(NamedTuple):
    """A possible end of a mission."""

    succeeds: bool
    message: str


class Success(NamedTuple):
    """The shortest path to an end that succeeds: its numbers of commands and events."""

    commands: int
    events: int


Given = tuple[str, str]
"""A phase, and the name of a command in it."""


@dataclass(frozen=True)
class Abilities:
    """The whole possible behaviour of a mission.

    Attributes:
        facts: Single properties: the robot, the initial states, the time limit.
        phases: The reachable phases, with a content for recognising renamed phases.
        commands: Commands that can be given, with their options.
        triggers: Triggers that can fire, by phase and name.
        outcomes: The possible ends, by name.
        failures: The names of the ends that follow if one command fails and nothing else goes
            wrong. Refusals are failures.
        faults: The target of each fault, by phase and code; other faults stop the mission.
        broken: Rules that can be violated, each with the command that violates it.
        rules: Rules that are in force.
        success: The shortest success; None if there is none.
        complete: Whether the exploration was complete.
    """

    facts: Mapping[str, str]
    phases: Mapping[str, Hashable]
    commands: Mapping[Given, str]
    triggers: Mapping[tuple[str, str], Trigger]
    outcomes: Mapping[str, PossibleEnd]
    failures: Mapping[Given, frozenset[str]]
    faults: Mapping[tuple[str, str], str]
    broken: frozenset[str]
    rules: frozenset[str]
    success: Success | None
    complete: bool


Triggers: TypeAlias = Mapping[tuple[str, str], Trigger]


def renamed(old: Mapping[str, Hashable], new: Mapping[str, Hashable]) -> dict[str, str]:
    """Return new names by old names, for content that occurs once in each version."""
    lost = {name: content for name, content in old.items() if name not in new}
    gained = {name: content for name, content in new.items() if name not in old}
    there, here = Counter(lost.values()), Counter(gained.values())
    by_content = {content: name for name, content in gained.items()}
    return {
        name: by_content[content]
        for name, content in lost.items()
        if content != () and there[content] == here[content] == 1
    }


def in_new_names(old: Abilities, names: Mapping[str, str]) -> Abilities:
    """Return the behaviour with the new names of phases and ends."""

    def new(name: str) -> str:
        return names.get(name, name)

    facts = {name: new(value) for name, value in old.facts.items()}
    return replace(
        old,
        facts=facts,
        phases={new(name): content for name, content in old.phases.items()},
        commands={(new(phase), name): terms for (phase, name), terms in old.commands.items()},
        triggers={
            (new(phase), new(name)): Trigger(each.text, tuple(map(new, each.go)))
            for (phase, name), each in old.triggers.items()
        },
        outcomes={new(name): outcome for name, outcome in old.outcomes.items()},
        failures={
            (new(phase), name): frozenset(map(new, ends))
            for (phase, name), ends in old.failures.items()
        },
        faults={(new(phase), code): new(go) for (phase, code), go in old.faults.items()},
    )


def matched_triggers(old: Triggers, new: Triggers) -> Triggers:
    """Return the old triggers, renamed to the new triggers that wait for the same.

    A trigger without a name of its own has the name of its target.
    """
    kept = {key for key, each in old.items() if key in new and new[key].text == each.text}
    alike = {(key[0], each.text): key for key, each in new.items() if key not in kept}
    found = {key: old[key] for key in kept}
    others = []
    for (phase, name), each in old.items():
        if (phase, name) in kept:
            continue
        if (phase, each.text) in alike:
            found[alike[phase, each.text]] = each
        else:
            others.append((phase, name, each))
    for phase, name, each in others:
        found[(phase, each.text) if (phase, name) in found else (phase, name)] = each
    return found
