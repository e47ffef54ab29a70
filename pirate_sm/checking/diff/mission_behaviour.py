"""The possible behaviour of a mission: phases, commands, triggers, outcomes, failures, faults.

It is derived from an exploration of everything that can happen, so steps that are never reached
are not part of it.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

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


class Outcome(NamedTuple):
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
    outcomes: Mapping[str, Outcome]
    failures: Mapping[Given, frozenset[str]]
    faults: Mapping[tuple[str, str], str]
    broken: frozenset[str]
    rules: frozenset[str]
    success: Success | None
    complete: bool
