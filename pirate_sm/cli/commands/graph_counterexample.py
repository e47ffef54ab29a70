"""The phases of an event sequence, which `pirate graph --counterexample` marks."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path

from pirate_sm.core.effects import Effect
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import Event
from pirate_sm.running.runtime.ending import SUCCEEDED, Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import CoursePlayer
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.backends import read_script
from pirate_sm.views.drawing.graph.highlight import RunPath
from pirate_sm.views.drawing.graph.highlight import Stop as Reached


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


class _EndOfCourse:
    """A companion that stops a run when its event sequence is over."""

    due_s = inf
    listening = False

    def __init__(self, player: CoursePlayer, requests: StopRequests) -> None:
        self._player = player
        self._requests = requests

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask the run to stop after the last event."""
        if self._player.over:
            self._requests.ask(Stop("the event sequence is over", SUCCEEDED))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return no event."""
        return ()
