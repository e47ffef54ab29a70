"""Makes the backend ``trace``: nothing moves; a script or each wait's first trigger decides."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pirate_sm.core.documents import read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission, trace_script
from pirate_sm.core.mission import Happening
from pirate_sm.core.program import Wait
from pirate_sm.core.registry import Plugin
from pirate_sm.core.spelling import unknown
from pirate_sm.robot.backends import known
from pirate_sm.robot.backends.trace import IDEAL, SCRIPTED, TraceBackend, Verdicts
from pirate_sm.running.runtime.course_player import CoursePlayer, longest_s
from pirate_sm.running.runtime.trace_repeats import LoopWatch
from pirate_sm.running.runtime.trigger_script import Firing, TriggerScript
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.running.wiring.run_order import Order


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return a trace, with the companions that fire triggers in it.

    Raises:
        UsageError: No wait has a trigger to be fired.
    """
    if order.course:
        return _course(order, loaded)
    _check_firings(order.firings, loaded)
    script = TriggerScript(loaded.program, order.firings)
    watch = LoopWatch(lambda: len(script.unused))
    return Equipment(backend=TraceBackend(), companions=(watch, script), notices=(IDEAL,))


def _course(order: Order, loaded: LoadedMission) -> Equipment:
    """Return a trace that plays an event sequence."""
    if order.firings:
        raise UsageError("an event sequence cannot be combined with triggers to fire")
    events = trace_script.resolve_course(order.course, loaded.robot)
    known = [each.report for each in events if each.happening.happens == "start" and each.report]
    later = [each for each in events if each.happening.happens != "start"]
    verdicts = Verdicts(scripted=True)
    program = loaded.program
    player = CoursePlayer(later, program, verdicts.decide, verdicts.release)
    # The duration of commands in a trace must not count against a time limit.
    limit_s = program.time_limit_s + longest_s(order.course, loaded.robot, program)
    return Equipment(
        backend=TraceBackend(verdicts, known),
        loaded=replace(loaded, program=replace(program, time_limit_s=limit_s)),
        companions=(player,),
        notices=(SCRIPTED,),
        attended=True,
    )


def read_script(path: Path) -> tuple[tuple[Firing, ...], tuple[Happening, ...]]:
    """Return the firings in a file, or its whole event sequence.

    Raises:
        LoadError: The file has errors; it lists all of them.
    """
    script = trace_script.read_script(read_document(path))
    firings = (Firing(each.trigger, each.after, each.phase) for each in script.entries)
    return tuple(firings), script.course


def _check_firings(firings: tuple[Firing, ...], loaded: LoadedMission) -> None:
    waits = [each for each in loaded.program.instructions if isinstance(each, Wait)]
    phases = {wait.phase for wait in waits}
    asked: dict[str, list[str]] = {}
    for firing in firings:
        asked.setdefault(firing.phase, []).append(firing.trigger)
    named = [phase for phase in asked if phase]
    wrong = [unknown("nothing waits in a phase", named, sorted(phases))]
    for phase, triggers in asked.items():
        here = [wait for wait in waits if phase in ("", wait.phase)]
        known = {trigger.name for wait in here for trigger in wait.triggers} | {"within"}
        if here:
            where = f"in the phase '{phase}' " if phase else ""
            wrong.append(unknown(f"nothing {where}waits for a trigger", triggers, sorted(known)))
    if any(wrong):
        raise UsageError("\n".join(filter(None, wrong)))


BACKEND: Plugin[MakeBackend] = Plugin(known.ABOUT["trace"], make)
