"""What is said of a word of a mission: of a command, a signal, a phase, an end, a fault."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import inf, isinf
from typing import Final

from pirate_sm.checking.exploring.signal_ranges import ANYTHING
from pirate_sm.checking.reports.text import explained
from pirate_sm.core.documents import cut
from pirate_sm.core.events import BUILT_IN_FAULTS
from pirate_sm.core.expressions import EnumType
from pirate_sm.core.program import Branch, TriggerSpec, Wait
from pirate_sm.core.spelling import listed
from pirate_sm.core.units import describe, unit_of
from pirate_sm.views.drawing.robot_page import command_blocks, markdown
from pirate_sm.views.editor.known_mission import KnownMission

NEVER: Final = "never reached"


def detail(known: KnownMission, word: str) -> str:
    """Return what a word is, in a few words; empty if it is none of the mission's names."""
    robot, mission = known.loaded.robot, known.loaded.mission
    name = known.loaded.loaded_robot.profile.aliases.get(word, word)
    if name in robot.table.command_index:
        spec = robot.commands[robot.table.command_index[name]]
        return f"command, usually {spec.nominal_s:g} s, at most {spec.timeout_s:g} s"
    if (kind := robot.vocabulary.types.get(word)) is not None:
        if isinstance(kind, EnumType):
            return f"signal, {listed(kind.values, 'or')}"
        low, high = known.ranges.get(word, ANYTHING)
        limited = low > -inf or high < inf
        within = f", {low:.4g} … {high:.4g} {unit_of(kind.dimension)}" if limited else ""
        return f"signal, {describe(kind.dimension)}{within}".rstrip()
    if word in mission.parameters:
        return f"parameter, {known.loaded.parameters[word]}"
    if word in mission.phases or word in mission.ends:
        what, time = "phase" if word in mission.phases else "end", times(known, word)
        return f"{what}, {time}" if time == NEVER else f"{what}, reached after {time}"
    return "fault" if word in robot.fault_codes else ""


def times(known: KnownMission, name: str) -> str:
    """Return the shortest and the longest time to a phase or an end, ``3.2 s … 45 s``, or never."""
    shortest_s, longest_s = known.times_s(name)
    if isinf(shortest_s):
        return NEVER
    return f"{shortest_s:.3g} s … " + ("any time" if isinf(longest_s) else f"{longest_s:.4g} s")


def about(known: KnownMission, word: str, line: int = 0) -> str:
    """Return all that is known of a name of the mission, as Markdown; empty for other words.

    Args:
        known: The mission.
        word: The word.
        line: Its line, for the conditions there; 0 to say nothing of them.
    """
    said = detail(known, word)
    found = [f"**{word}**: {said}", *_more(known, word)] if said else []
    if not said or word in known.loaded.robot.vocabulary.types:
        found += _conditions(known, line)
    return "\n\n".join(filter(None, dict.fromkeys(found)))


def _more(known: KnownMission, word: str) -> Iterator[str]:
    loaded = known.loaded
    robot, mission = loaded.loaded_robot, loaded.mission
    name = robot.profile.aliases.get(word, word)
    if name in robot.profile.commands:
        yield markdown([*command_blocks(robot, name)][1:])
    elif word in mission.parameters:
        yield mission.parameters[word].description
    elif word in mission.phases:
        yield mission.phases[word].description
        for region, states in known.states_in(word).items():
            yield f"{region}: {listed(states, 'or')}"
    elif word in mission.ends:
        yield mission.ends[word].succeed or mission.ends[word].fail or ""
    elif word in BUILT_IN_FAULTS:
        yield explained(word)
    else:
        for rule in loaded.robot.faults:
            if rule.code == word:
                yield f"{rule.message}: when `{cut(rule.when.text)}` for {rule.held_s:g} s"


def _conditions(known: KnownMission, line: int) -> Iterator[str]:
    """Yield what is known of the conditions that begin on a line: their truth, their signals."""
    own, names = known.loaded.documents[0].name, dict[str, None]()
    for it in known.loaded.program.instructions:
        parts: Sequence[TriggerSpec | Branch] = it.triggers if isinstance(it, Wait) else ()
        for each in [it] if isinstance(it, Branch) else parts:
            if each.condition is None or not each.place.startswith(f"{own}:{line}:"):
                continue
            if not names:
                if isinstance(each, Branch):
                    truth = _of_branch(known, each)
                elif isinstance(it, Wait):
                    truth = _of_trigger(known, it, each.name)
                yield f"`{each.condition.text}`{truth}"
            names |= dict.fromkeys(re.findall(r"\w+", " ".join(sorted(each.condition.names))))
    for name in names.keys() & known.loaded.robot.vocabulary.types.keys():
        yield f"**{name}**: {detail(known, name)}"


def _of_trigger(known: KnownMission, it: Wait, name: str) -> str:
    """Return when the condition of a trigger is true; empty while that was not explored."""
    waits = [
        book.waits[key] for book in known.explored if (key := (it.phase, it.place)) in book.waits
    ]
    armed, fired = sum(len(w.armed) for w in waits), sum(len(w.fired[name]) for w in waits)
    if not known.explored:
        return ""
    if not armed:
        return ": this wait is never reached"
    if not fired:
        return ": it never ends this wait"
    at_once = sum(each.at_once[name] for each in waits) == armed
    return ": true already whenever the wait begins" if at_once else ": it can become true"


def _of_branch(known: KnownMission, it: Branch) -> str:
    answers = {e.truth for book in known.explored for e in book.found.branches.get(it.place, ())}
    if len(answers) == 1:
        return ": always true" if True in answers else ": never true"
    return ": true or not" if answers else ""
