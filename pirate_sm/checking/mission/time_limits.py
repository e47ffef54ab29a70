"""Times that are too short for what they limit, and questions that may stay open for ever."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from math import inf, isinf

from pirate_sm.checking.exploring.exploration_index import Ledger
from pirate_sm.checking.exploring.explore import Exploration
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.mission_places import Places
from pirate_sm.engine.mission.program import Do, Question
from pirate_sm.loading.mission import LoadedMission


def time_findings(
    books: Sequence[Ledger], loaded: LoadedMission, places: Places
) -> Iterator[Finding]:
    """What is wrong with the times of a mission's own file.

    Args:
        books: What can happen.
        loaded: The mission.
        places: Of its parts.
    """
    told: set[str] = set()
    for each in loaded.program.instructions:
        if not isinstance(each, Do | Question) or each.place in told:
            continue
        if places.read(each.place).file != loaded.documents[0].name:
            continue
        told.add(each.place)
        found = _timeout(each, loaded) if isinstance(each, Do) else _open(each, loaded)
        if found is not None:
            code, severity, message = found
            yield places.finding(places.read(each.place), code, severity, message)
    yield from _limit(books, loaded, places)


def _timeout(it: Do, loaded: LoadedMission) -> tuple[str, Severity, str] | None:
    """A command that is given less time than it takes."""
    spec = loaded.robot.commands[it.command]
    for_s = getattr(spec.done, "for_s", 0.0)
    if it.timeout_s is None:
        return None
    if it.timeout_s <= for_s:
        message = f"{spec.name} is done once its signs have held for {for_s:g} s, and may take "
        return "step.timeout", Severity.ERROR, f"{message}{it.timeout_s:g} s: it always fails"
    if it.timeout_s < spec.nominal_s:
        message = (
            f"{spec.name} takes {spec.nominal_s:g} s as a rule, and may take {it.timeout_s:g} s"
        )
        return "step.timeout", Severity.WARNING, message
    return None


def _open(it: Question, loaded: LoadedMission) -> tuple[str, Severity, str] | None:
    """A question that nobody need ever answer."""
    if not (isinf(it.timeout_s) and isinf(loaded.program.time_limit_s)):
        return None
    message = "neither the question nor the mission has a longest time"
    return "ask.unbounded", Severity.WARNING, message


def _limit(books: Sequence[Ledger], loaded: LoadedMission, places: Places) -> Iterator[Finding]:
    """A mission that cannot succeed within its limit, if commands take as long as they do."""
    limit_s = loaded.program.time_limit_s
    if isinf(limit_s) or not books[-1].found.complete:
        return
    least_s = _shortest_s(books[-1].found)
    if limit_s < least_s < inf:
        yield places.finding(
            places.of(("time_limit",)), "limit.too_short", Severity.WARNING,
            f"the shortest way to an end that succeeds takes {least_s:.3g} s as a rule, "
            f"and the mission may take {limit_s:g} s",
        )  # fmt: skip


def _shortest_s(found: Exploration) -> float:
    """How long an end that succeeds takes at least, with commands of nominal duration."""
    after: list[list[tuple[int, float]]] = [[] for _ in found.nodes]
    waiting: list[tuple[float, int]] = []
    for step in found.steps:
        if step.source < 0:
            heappush(waiting, (0.0, step.target))
        else:
            took_s = max(step.move.at_s - found.nodes[step.source].now, 0.0)
            after[step.source].append((step.target, took_s))
    known: set[int] = set()
    while waiting:
        time_s, node = heappop(waiting)
        if node in known:
            continue
        known.add(node)
        ending = found.nodes[node].state.mission.ending
        if ending is not None and ending.outcome == "succeeded":
            return time_s
        for target, took_s in after[node]:
            heappush(waiting, (time_s + took_s, target))
    return inf
