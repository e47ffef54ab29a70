"""The lines that show a person what is known of a robot whose run was cut off."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import NamedTuple

from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Do, Program, Wait, successors
from pirate_sm.core.resuming import Reconciled, Resumption, VerdictTable
from pirate_sm.running.wiring.resume_offer import EndOfRun, Offer, Said
from pirate_sm.running.wiring.resumed_run import first_wheel_m

_NEXT = 3


class ResumeFacts(NamedTuple):
    """What is known when a person is asked; ``dark_s`` is how long nobody has recorded, s."""

    end: EndOfRun
    loaded: LoadedMission
    dark_s: float
    shows: Reconciled
    offer: Offer
    said: Said


def report_lines(facts: ResumeFacts) -> Iterator[str]:
    """Yield the lines: where it was, what is seen, where the robot is, what comes next."""
    end, header, offer = facts.end, facts.end.recording.header, facts.offer
    phase = end.loaded.program.phase_of[end.last.mission.pc]
    yield f"{header.mission} on {header.backend}, began {header.began}"
    yield (
        f"cut off at {end.last_s - end.began_s:.3f} s in the phase {phase}, "
        f"{_doing(facts.loaded, end)}; dark for {_duration(facts.dark_s)}"
    )
    yield from (f"said: {each}" for each in facts.said.words)
    for table in facts.shows.tables if offer.table is None else (offer.table,):
        command = table.hypothesis.command
        yield f"  if {command} was accepted:" if command else "  as recorded:"
        yield from verdict_lines(table)
    yield f"position: {_position(facts)}"
    if offer.it is not None:
        names = list(_next_commands(facts.loaded, offer.it))
        yield f"next: {', '.join(names) or 'no command'}"
    yield from (f"unknown: {each}" for each in (*offer.unknown, *offer.unplaced))
    if offer.forecast is not None:
        why = f": {offer.forecast.why}" if offer.forecast.why else ""
        yield f"expected: {offer.forecast.word}{why}"
        yield from (f"    {each}" for each in offer.forecast.course)
    yield from (f"cannot continue: {each}" for each in offer.refusals)
    if not offer.refusals:
        yield "can continue" + " once you say where the robot is" * bool(offer.unplaced)


def verdict_lines(table: VerdictTable) -> Iterator[str]:
    """Yield what the sensors show of each state and clamp, and by which signals."""
    recorded = table.hypothesis.name != "adopted"
    for each in table.verdicts:
        why = f" ({each.why})" if each.why else ""
        yield f"    {each.word:12} {each.about} {each.state}{why}"
        for shown in each.shown:
            before = f"recorded {shown.recorded}, " * recorded
            yield f"                 {shown.signal} {shown.seen}, {before}limit {shown.limit}"


def _position(facts: ResumeFacts) -> str:
    way, was_m = facts.shows.way, first_wheel_m(facts.end)
    was = "not recorded" if was_m is None else f"first wheel at {was_m:.3f} m at the end"
    if facts.said.start_at_m is not None:
        return f"{was}; the operator says {facts.said.start_at_m:.3f} m now"
    if way.high_m == inf:
        return f"{was}, unknown since: {way.why}"
    middle_mm, off_mm = (500 * (way.high_m + sign * way.low_m) for sign in (1, -1))
    return f"{was}, {middle_mm:+.0f} mm ± {off_mm:.0f} mm since: {way.why}"


def _doing(loaded: LoadedMission, end: EndOfRun) -> str:
    motion, it = end.last.robot.motion, end.loaded.program.instructions[end.last.mission.pc]
    if motion is not None:
        return f"during {loaded.robot.commands[motion.command].name}"
    if end.maybe is not None:
        return f"{loaded.robot.commands[end.maybe].name} may have been sent since"
    return "waiting" if isinstance(it, Wait) else "between two commands"


def _next_commands(loaded: LoadedMission, it: Resumption) -> Iterator[str]:
    """Yield the next commands on the way that the file names first."""
    program: Program = it.program(loaded.program)
    at, seen, found = program.start, set[int](), 0
    while at >= 0 and at not in seen and found < _NEXT:
        seen.add(at)
        step = program.instructions[at]
        if isinstance(step, Do):
            found += 1
            yield loaded.robot.commands[step.command].name
        at = next(iter(successors(program, at)), -1)


def _duration(seconds: float) -> str:
    if seconds < 120:
        return f"{seconds:.1f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
