"""Find the parts of a mission that were only renamed in the new version."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import TypeAlias

from pirate_sm.checking.diff.mission_behaviour import Abilities, Trigger

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
