"""A rule about reachability: phases and ends, loops without exit, broken safety rules."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from pirate_sm.checking.exploring.exploration import MISHAPS, Exploration, ExploredState
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.loading import LoadedMission


def reachability(view: MissionView) -> Iterator[Finding]:
    """Yield findings about the paths through the mission."""
    books, seen, loaded, places = view.explored, view.seen, view.loaded, view.places
    if not view.complete:
        yield from _round_and_round(books, loaded, places)
        yield from _rules(books, places)
        return
    yield from _unreachable(seen, loaded, places)
    endless = list(_endless(books, loaded, places))
    yield from endless
    yield from _round_and_round(books, loaded, places)
    reached = {end for book in seen for end in book.ends}
    succeeds = [name for name, end in loaded.mission.ends.items() if end.succeed is not None]
    if not any(outcome == "succeeded" for outcome, _ in reached):
        message = "no path leads to an end that succeeds"
        if not succeeds:
            message = "it has no end that succeeds"
        yield places.finding(places.mission(), "mission.no_success", message)
    yield from _rules(books, places)


def _unreachable(
    seen: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    phases = {phase for book in seen for phase in book.phases}
    ends = {end for book in seen for _, end in book.ends}
    for code, kind, names, reached in (
        ("phase.unreachable", "phase", loaded.mission.phases, phases),
        ("end.unreachable", "end", loaded.mission.ends, ends),
    ):
        for name in names:
            if name not in reached:
                place = places.of((f"{kind}s", name), key=True)
                yield places.finding(place, code, f"nothing leads to the {kind} '{name}'")


def _endless(
    books: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    """Yield phases from which no end can be reached without a failure, a fault or the operator."""
    found = books[-1].found
    if isfinite(loaded.program.time_limit_s):
        return
    lost = cannot_end(found)
    if not lost:
        return
    first = min(lost)
    phase = found.program.phase_of[found.nodes[first].state.mission.pc]
    own = phase.split("/", 1)[0]
    sure = any(found.nodes[node].sure for node in lost)
    others = sorted(
        {
            found.program.phase_of[found.nodes[node].state.mission.pc].split("/", 1)[0]
            for node in lost
        }
        - {own, ""}
    )
    also = f" (nor from {', '.join(others)})" if others else ""
    place = places.of(("phases", own), key=True)
    message = f"from the phase '{own}' no end can be reached{also} unless something fails"
    yield places.finding(
        place,
        "loop.endless",
        message,
        severity=None if sure else Severity.POSSIBLE,
        happens=(found, found.nodes[first].step),
        playable=len(books) == 1,
    )


def cannot_end(found: Exploration) -> set[int]:
    """Return states from which no end, or none that succeeds, is reached without a mishap."""
    usual: dict[int, list[int]] = defaultdict(list)
    every: dict[int, list[int]] = defaultdict(list)
    for step in found.steps:
        every[step.target].append(step.source)
        if step.move.kind not in MISHAPS:
            usual[step.target].append(step.source)
    over = {index for index, node in enumerate(found.nodes) if node.over}
    good = {index for index in over if _succeeds(found.nodes[index])}
    return set(range(len(found.nodes))) - _leading_to(over, usual) - _leading_to(good, every)


def _succeeds(node: ExploredState) -> bool:
    ending = node.state.mission.ending
    return ending is not None and ending.outcome == "succeeded"


def _leading_to(targets: set[int], before: Mapping[int, Sequence[int]]) -> set[int]:
    """Return the states from which one of the targets is reached, including the targets."""
    can, pending = set(targets), list(targets)
    while pending:
        for source in before.get(pending.pop(), ()):
            if source >= 0 and source not in can:
                can.add(source)
                pending.append(source)
    return can


def _round_and_round(
    books: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    for book in books:
        if not book.round_and_round:
            continue
        step = book.found.steps[book.round_and_round[0]]
        entered = [each.phase for each in step.effects if isinstance(each, PhaseChange)]
        circle = list(dict.fromkeys(entered[entered.index(entered[-1]) :]))
        first = next((each for each in entered if each in circle), "")
        phase = first.split("/", 1)[0]
        path = ("phases", phase) if phase in loaded.mission.phases else ("phases",)
        way = " → ".join([*circle[circle.index(first) :], *circle[: circle.index(first)], first])
        place, message = places.of(path, key=True), f"{way}: this loop never waits"
        severity = None if step.sure else Severity.POSSIBLE
        yield places.finding(place, "loop.instant", message, severity=severity)
        return


def _rules(books: Sequence[Explored], places: MissionPlaces) -> Iterator[Finding]:
    reported: set[str] = set()
    for book in books:
        for message, number in book.broken.items():
            if message in reported:
                continue
            reported.add(message)
            state = book.found.nodes[book.found.steps[number].target].state.mission
            at = getattr(book.found.program.instructions[state.pc], "place", "")
            yield places.finding(
                places.read(at) if at else places.mission(),
                "rule.violated",
                message,
                severity=None if book.sure(number) else Severity.POSSIBLE,
                happens=(book.found, number),
                playable=book is books[0],
            )
