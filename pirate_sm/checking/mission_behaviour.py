"""The possible behaviour of a mission, from an exploration, in names that can be compared.

Steps that are never reached are not part of it.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import isinf
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.exploring.exploration import (
    WITHIN,
    Exploration,
    Explored,
    ExploredStep,
    index_exploration,
)
from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.core import program as steps
from pirate_sm.core.effects import CommandStatus, Ended, PhaseChange
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import RobotSpec

# --- behaviours and their names ------------------------------------------------------------------
# It is derived from an exploration of everything that can happen, so steps that are never reached
# are not part of it.


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
        rules: Rules that are active.
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


# --- from an exploration -------------------------------------------------------------------------


_PLACE = re.compile(r" \([^()]*:\d+:\d+\)")


def abilities_of(loaded: LoadedMission) -> Abilities:
    """Explore a mission and return its possible behaviour."""
    program = loaded.program
    found = explore(loaded.robot, program, conditions_of(loaded))
    book, reader = index_exploration(found), _Reader(found)
    phases = {name: _content(loaded, name) for name in program.phases if name in book.phases}
    return Abilities(
        _facts(loaded),
        phases,
        reader.commands(),
        _triggers(book, program),
        _outcomes(book, program),
        reader.failures(),
        _faults(program, phases),
        frozenset(_PLACE.sub("", message) for message in book.broken),
        frozenset(rule.name for rule in program.rules),
        _success(book),
        found.complete,
    )


def _facts(loaded: LoadedMission) -> dict[str, str]:
    program, robot = loaded.program, loaded.robot
    first = program.instructions[program.start]
    while isinstance(first, steps.SwitchControl):
        first = program.instructions[first.next]
    states = robot.table.configurations[program.start_configuration]
    limit_s = program.time_limit_s
    begun = {f"{each} at the start": at for each, at in zip(robot.regions, states, strict=True)}
    return {
        "robot": robot.name,
        "polarity": robot.polarity,
        "first phase": first.phase if isinstance(first, steps.Enter) else "",
        **begun,
        "control": loaded.mission.control or "none",
        "time limit": "none" if isinf(limit_s) else f"{limit_s:g} s",
    }


def _content(loaded: LoadedMission, phase: str) -> Hashable:
    """Return the content of a phase, without the names of phases and ends."""
    program = loaded.program
    return tuple(
        _said(each, loaded.robot)
        for each, home in zip(program.instructions, program.phase_of, strict=True)
        if home == phase and not isinstance(each, steps.Enter)
    )


def _said(it: steps.Instruction, robot: RobotSpec) -> Hashable:
    match it:
        case steps.Do():
            return ("do", robot.commands[it.command].name, _terms(it))
        case steps.SwitchControl():
            return ("control", robot.controls[it.control].name)
        case steps.Branch():
            return ("if", it.condition.text)
        case steps.Wait():
            return ("wait", it.within_s, tuple(trigger.text for trigger in it.triggers))
        case steps.Question():
            return ("ask", it.text, tuple(choice for choice, _ in it.choices), it.timeout_s)
        case steps.Require():
            return ("require", it.states)
        case steps.Say() | steps.Raise() | steps.Finish():
            return ("say", it.message)
        case steps.Enter():
            return ()


def _terms(it: steps.Do) -> str:
    """Return the options of a command: timeout, retries, and whether it may be unneeded."""
    parts = [] if it.timeout_s is None else [f"timeout {it.timeout_s:g} s"]
    parts += [f"retry {it.retries}"] if it.retries else []
    parts += ["unneeded: skip"] if it.skip_unneeded else []
    return ", ".join(parts) or "as usual"


class _Reader:
    """Derives the results of commands from an exploration."""

    def __init__(self, found: Exploration) -> None:
        self._found = found
        self._homes: dict[str, dict[str, str]] = defaultdict(dict)  # terms by place and phase
        for each, home in zip(found.program.instructions, found.program.phase_of, strict=True):
            if isinstance(each, steps.Do | steps.Require) and each.place:
                self._homes[each.place][home] = _terms(each) if isinstance(each, steps.Do) else ""

    def commands(self) -> dict[Given, str]:
        """Return the commands that can be given, with their options."""
        terms: dict[Given, set[str]] = defaultdict(set)
        for step in self._found.steps:
            for phase, status in self._statuses(step):
                if status.status == "sent":
                    terms[phase, status.name].add(self._homes[status.place][phase])
        return {given: "; ".join(sorted(said)) for given, said in terms.items()}

    def failures(self) -> dict[Given, frozenset[str]]:
        """Return the ends that follow the failure of each command if nothing else goes wrong."""
        after = self._ends_after()
        ends: dict[Given, set[str]] = defaultdict(set)
        for step in self._found.steps:
            if step.source >= 0 and self._found.nodes[step.source].state.mission.diverting:
                continue  # that is the second thing to go wrong
            for phase, status in self._statuses(step):
                failed = status.status == "failed" and step.move.kind in {"failed", "rejected"}
                if failed or status.status == "refused":
                    ends[phase, status.name] |= after[step.target]
        return {given: frozenset(names) for given, names in ends.items()}

    def _statuses(self, step: ExploredStep) -> Iterator[tuple[str, CommandStatus]]:
        """Yield the command statuses in a step, each with the phase of the command."""
        at = self._found.nodes[step.source].state.mission.pc if step.source >= 0 else 0
        phase = self._found.program.phase_of[at]
        for effect in step.effects:
            if isinstance(effect, PhaseChange):
                phase = effect.phase
            elif isinstance(effect, CommandStatus) and effect.place in self._homes:
                homes = self._homes[effect.place]
                # After a call its caller continues without saying that its phase does.
                yield phase if phase in homes else next(iter(homes)), effect

    def _ends_after(self) -> list[set[str]]:
        """Return for each state the ends reached from it while nothing goes wrong."""
        found = self._found
        before: dict[int, list[int]] = defaultdict(list)
        over: dict[str, set[int]] = defaultdict(set)
        for step in found.steps:
            for _, end in _ends_of(found, step):
                over[end or STOPPED].add(step.target)
            if not step.went_wrong:
                before[step.target].append(step.source)
        after: list[set[str]] = [set() for _ in found.nodes]
        for end, nodes in over.items():
            pending = list(nodes)
            while pending:
                node = pending.pop()
                if node >= 0 and end not in after[node]:
                    after[node].add(end)
                    pending += before[node]
        return after


def _ends_of(found: Exploration, step: ExploredStep) -> Iterator[tuple[str, str]]:
    """Yield the outcome and name of the end to which a step leads, if any."""
    ending = found.nodes[step.target].state.mission.ending
    if ending is not None:
        yield ending.outcome, ending.end
    for effect in step.effects:
        if isinstance(effect, Ended):
            yield effect.outcome, effect.end


def _triggers(book: Explored, program: steps.Program) -> dict[tuple[str, str], Trigger]:
    known: dict[tuple[str, str], dict[tuple[str, str], None]] = defaultdict(dict)
    for each in program.instructions:
        if isinstance(each, steps.Wait):
            for trigger in each.triggers:
                go = _target(program, trigger.go, trigger.go_name)
                known[each.phase, trigger.name][trigger.text, go] = None
            go = _target(program, each.within, each.within_name)
            known[each.phase, WITHIN][f"{each.within_s:g} s", go] = None
    return {
        (phase, name): Trigger(
            " or ".join(dict.fromkeys(text for text, _ in known[phase, name])),
            tuple(dict.fromkeys(go for _, go in known[phase, name])),
        )
        for (phase, _), wait in book.waits.items()
        for name in wait.fired
    }


def _target(program: steps.Program, index: int, name: str) -> str:
    """Return the full name of the phase or end at an index, or the name as written."""
    if not 0 <= index < len(program.instructions):
        return name
    match program.instructions[index]:
        case steps.Enter(phase=phase):
            return phase
        case steps.Finish(end=end):
            return end
        case _:
            return name


def _outcomes(book: Explored, program: steps.Program) -> dict[str, PossibleEnd]:
    messages = {it.end: it.message for it in program.instructions if isinstance(it, steps.Finish)}
    return {
        end or STOPPED: PossibleEnd(outcome == "succeeded", messages.get(end, ""))
        for outcome, end in book.ends
    }


def _faults(program: steps.Program, phases: Mapping[str, Hashable]) -> dict[tuple[str, str], str]:
    found: dict[tuple[str, str], str] = {}
    for phase, handlers in zip(program.phase_of, program.handlers, strict=True):
        if phase not in phases:
            continue
        for each in handlers:  # the innermost first
            go = IGNORED if each.go is None else _target(program, each.go, each.go_name)
            whose = f" of {', '.join(sorted(each.of))}" if each.of else ""
            found.setdefault((phase, f"{each.code}{whose}"), go)
    return found


def _success(book: Explored) -> Success | None:
    paths = [
        book.found.path(number)
        for (outcome, _), number in book.ends.items()
        if outcome == "succeeded"
    ]
    ways = [Success(sum(map(_given, path)), len(path)) for path in paths]
    return min(ways, key=lambda way: way.events, default=None)


def _given(step: ExploredStep) -> int:
    return sum(isinstance(each, CommandStatus) and each.status == "sent" for each in step.effects)
