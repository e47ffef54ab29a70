"""Missions that are played for a command: rehearsed for a check, or along a counterexample."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib import import_module
from math import inf
from pathlib import Path

from pirate_sm.checking.reports.check_report import Nearly, Rehearsal, Rehearse, RehearsedRun
from pirate_sm.cli.errors import say
from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Effect, TriggerFired, WaitArmed
from pirate_sm.core.engine import has_come
from pirate_sm.core.errors import ExitCode, UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Wait
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.near_misses import NearMiss, NearMisses
from pirate_sm.running.runtime.scripted_events import CoursePlayer, FirstChoice, Patience
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.backends import read_script
from pirate_sm.views.drawing.graph.highlight import RunPath
from pirate_sm.views.drawing.graph.highlight import Stop as Reached

# --- rehearsals ---------------------------------------------------------------------------------


MOST_CALLS = 5
LEAST_SHARE = 0.1
"""The least share of a limit at which a near miss is listed."""

_SIMULATOR = "pirate_sm.simulation.kinematic.world"


def rehearsing(seeds: int) -> Rehearse:
    """Return a function that runs missions in the simulator.

    Args:
        seeds: Number of runs, with seeds from 0.

    Raises:
        UsageError: The simulator is neither built nor can it compile itself.
    """
    import_module(_SIMULATOR)

    def rehearse(loaded: LoadedMission, path: Path) -> Rehearsal:
        return _rehearsed(loaded, path, seeds)

    return rehearse


def _rehearsed(loaded: LoadedMission, path: Path, seeds: int) -> Rehearsal:
    if loaded.pipe is None:
        return Rehearsal(shown(path), skipped="it names no pipe; --pipe gives one")
    runs, calls = [], dict[str, tuple[NearMiss, int]]()
    early = _Early(loaded)
    for seed in range(seeds):
        try:
            run, nearest = _run(loaded, path, seed, early)
        except UsageError as error:
            return Rehearsal(shown(path), skipped=error.for_terminal)
        runs.append(run)
        for call in nearest:
            if call.about not in calls or call.share > calls[call.about][0].share:
                calls[call.about] = call, seed
    nearly = _closest(calls.values())
    return Rehearsal(shown(path), tuple(runs), nearly, at_once=tuple(early.found.items()))


def _closest(calls: Iterable[tuple[NearMiss, int]]) -> tuple[Nearly, ...]:
    """Return the closest calls, the closest first, from pairs of a call and its seed."""
    near = sorted(calls, key=lambda each: -each[0].share)
    return tuple(
        Nearly(call.text, call.share, call.at_s, seed)
        for call, seed in near[:MOST_CALLS]
        if call.share >= LEAST_SHARE
    )


def _run(
    loaded: LoadedMission, path: Path, seed: int, early: _Early
) -> tuple[RehearsedRun, list[NearMiss]]:
    prepared = prepare(Order(str(path), seed=seed), loaded, say)
    calls = NearMisses(loaded.robot, loaded.program)
    requests = StopRequests()
    run = MissionRun(
        prepared.engine,
        prepared.backend,
        observers=[early],
        requests=requests,
        tap=calls,
        companions=(*prepared.companions, FirstChoice(), Patience(requests)),
    )
    calls.follow(lambda: run.state)
    result = run.execute()
    if result.error is not None:
        raise result.error
    if result.ended.outcome == "interrupted" and requests.stop is None:
        raise KeyboardInterrupt  # the user has interrupted the check
    ended = result.ended
    return RehearsedRun(seed, ended.outcome, ended.message, result.now_s), calls.nearest()


class _Early:
    """Notices triggers whose condition has been true since their wait began.

    Attributes:
        found: Texts of their conditions, by their places.
    """

    def __init__(self, loaded: LoadedMission) -> None:
        self.found: dict[str, str] = {}
        self._armed_s: dict[str, float] = {}
        self._triggers = {
            (wait.phase, trigger.name): trigger
            for wait in loaded.program.instructions
            if isinstance(wait, Wait)
            for trigger in wait.triggers
        }

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note each trigger that fires as soon as it can, so was true when its wait began."""
        for effect in effects:
            if isinstance(effect, WaitArmed):
                self._armed_s[effect.phase] = now_s
            elif isinstance(effect, TriggerFired):
                trigger = self._triggers.get((effect.phase, effect.trigger))
                if trigger is None or trigger.condition is None:
                    continue
                if has_come(self._armed_s[effect.phase] + trigger.held_s, now_s):
                    self.found[trigger.place] = trigger.condition.text


# --- counterexamples ----------------------------------------------------------------------------


def phases_of_course(mission: Path, script: Path, settings: dict[str, str]) -> list[Reached]:
    """Return the phases that the mission reaches in a trace, and the end, in order.

    Args:
        mission: Its file.
        script: The event sequence.
        settings: Values of parameters.

    Raises:
        LoadError: The files have errors.
        UsageError: The script is for another mission or contains no event sequence.
    """
    _, course = read_script(script)
    if not course:
        raise UsageError(f"'{script}' lays down no event sequence")
    order = Order(str(mission), backend="trace", settings=settings, course=course)
    prepared = prepare(order)
    requests, way = StopRequests(), RunPath()
    players = [each for each in prepared.companions if isinstance(each, CoursePlayer)]
    MissionRun(
        prepared.engine,
        prepared.backend,
        observers=[way],
        requests=requests,
        companions=(*prepared.companions, *(_EndOfCourse(each, requests) for each in players)),
    ).execute()
    return way.stops


class _EndOfCourse(CompanionBase):
    """A companion that stops a run when its event sequence is over."""

    due_s = inf

    def __init__(self, player: CoursePlayer, requests: StopRequests) -> None:
        self._player = player
        self._requests = requests

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask the run to stop after the last event."""
        if self._player.over:
            self._requests.ask(Stop("the event sequence is over", ExitCode.SUCCEEDED))
