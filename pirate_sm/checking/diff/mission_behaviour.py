"""What a mission can do: phases, commands, triggers, outcomes, what becomes of failures and faults.

It is read off an exploration of everything that can happen, so a step that stands in the file and
whose turn never comes is not among it.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

STOPPED = "(safe stop)"
"""Stands for the safe stop after what nothing handles; no end can be called so."""

IGNORED = "(go on)"
"""Stands beside the phases that faults lead to, for a fault after which the mission goes on."""


class Trigger(NamedTuple):
    """What ends a wait.

    Attributes:
        text: The condition in words.
        go: Where it leads; more than one where a call is repeated with other values.
    """

    text: str
    go: tuple[str, ...]


class Outcome(NamedTuple):
    """How a mission can end."""

    succeeds: bool
    message: str


class Success(NamedTuple):
    """The shortest way to an end that succeeds: how much must happen on it."""

    commands: int
    events: int


Given = tuple[str, str]
"""A phase, and the name of a command that is given in it."""


@dataclass(frozen=True)
class Abilities:
    """All of it.

    Attributes:
        facts: What a mission has one of: its robot, where it begins, how long it may take.
        phases: Each phase that can be reached, with what a phase of another name must have in
            common to be the same.
        commands: Commands that can be given, with the terms on which they are.
        triggers: By phase and name those that can fire.
        outcomes: By the name of the end.
        failures: How the mission ends where a command fails and nothing else goes wrong: names
            of ends. Refusals are failures.
        faults: By phase and code where a fault leads; those not in it stop the mission.
        broken: Rules that can be violated, each with the command that would do so.
        rules: Rules that are watched.
        success: None where there is none.
        complete: Whether all of it is known; otherwise there was too much to look at.
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
