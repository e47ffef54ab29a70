"""The wording of differences between two versions of a mission."""

from __future__ import annotations

from collections.abc import Iterable

from pirate_sm.checking.diff.mission_behaviour import IGNORED, STOPPED, Outcome, Success, Trigger
from pirate_sm.checking.exploring.exploration import WITHIN


def trigger_words(name: str, trigger: Trigger) -> str:
    """Return what ends a wait, and its target."""
    return f"{cause(name, trigger)}, which leads to {quoted(trigger.go)}"


def cause(name: str, trigger: Trigger) -> str:
    """Return what ends a wait."""
    return f"its limit of {trigger.text}" if name == WITHIN else f"'{trigger.text}'"


def outcome_words(outcome: Outcome) -> str:
    """Return whether an end succeeds, with its message."""
    said = f": {outcome.message}" if outcome.message else ""
    return ("succeeds" if outcome.succeeds else "fails") + said


def end_words(name: str) -> str:
    """Return the name of an end."""
    return "the safe stop" if name == STOPPED else f"'{name}'"


def names_of_ends(names: frozenset[str]) -> str:
    """Return the names of ends."""
    return " or ".join(map(end_words, sorted(names))) or "nothing: it goes round for ever"


def handling(go: str) -> str:
    """Return the handling of a fault."""
    if not go:
        return "stops the mission"
    return "is only told" if go == IGNORED else f"leads to '{go}'"


def way_words(way: Success) -> str:
    """Return the number of commands and events on a path to success."""
    return f"{_count(way.commands, 'command')} and {_count(way.events, 'event')}"


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def quoted(names: Iterable[str]) -> str:
    """Return names in quotes, separated by commas."""
    return ", ".join(f"'{name}'" for name in names)
