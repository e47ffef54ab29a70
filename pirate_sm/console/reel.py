"""A recording as the console draws it: one snapshot after the other, made by the engine again."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator

from pirate_sm.detectors.route import Place, Route
from pirate_sm.errors import RecordingError
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.truth import Truth
from pirate_sm.recording.reader import Recording
from pirate_sm.recording.reloading import recorded_mission
from pirate_sm.recording.replay import engine_of, rerun
from pirate_sm.showing.anatomy import anatomy_of
from pirate_sm.showing.looking import Trends
from pirate_sm.showing.memory import Memory
from pirate_sm.showing.snapshot import Scene, Snapshot

MOST_FRAMES = 4000
"""So many moments of a recording can be looked at; a longer one has them farther apart."""

FINEST_S = 0.1

_PLACES = "/places"


class Reel:
    """Every moment of a recording that can be looked at.

    Args:
        frames: Snapshots in the order of their times, at least one.
    """

    def __init__(self, frames: list[Snapshot]) -> None:
        self.frames = frames
        self._times = [frame.now_s for frame in frames]

    @property
    def length_s(self) -> float:
        """Time of the last moment."""
        return self._times[-1]

    def at(self, time_s: float) -> Snapshot:
        """The newest moment that is not later than the time; the first one before it."""
        return self.frames[max(bisect_right(self._times, time_s) - 1, 0)]


def reel_of(recording: Recording) -> Reel:
    """The recording's moments.

    Raises:
        RecordingError: It is damaged, or nothing was recorded in it.
    """
    with recorded_mission(recording.header) as loaded:
        frames = list(_frames(recording, loaded))
    if not frames:
        raise RecordingError(f"{recording.path} ends before the run began")
    return Reel(frames)


def _frames(recording: Recording, loaded: LoadedMission) -> Iterator[Snapshot]:
    robot = loaded.robot
    engine = engine_of(recording, loaded)
    anatomy = anatomy_of(loaded.loaded_robot.profile, robot)
    scene = Scene(loaded, engine, anatomy, recording.header.backend)
    memory = Memory(robot, nominal=recording.header.nominal)
    places = _Places(recording, loaded)
    trends = Trends()
    every_s, due_s = _interval(recording), 0.0
    state, last_s = None, 0.0
    for again in rerun(recording, loaded):
        at_s = last_s = again.step.at_s
        memory.see(again.effects, at_s)
        state = again.state or state
        if state is None:
            continue
        trends.look(scene, state, at_s)
        if at_s >= due_s:
            due_s = at_s + every_s
            yield Snapshot(
                scene, at_s, state, memory.story(), places.at(at_s), not places.known,
                trends=trends.latest,
            )  # fmt: skip
    if state is not None:
        yield Snapshot(
            scene, last_s, state, memory.story(), places.at(last_s), not places.known,
            trends=trends.latest, over=recording.complete,
        )  # fmt: skip


def _interval(recording: Recording) -> float:
    """Time between two moments."""
    last_s = 0.0
    for step in recording.steps():
        last_s = step.at_s
    return max(FINEST_S, last_s / MOST_FRAMES)


class _Places:
    """Where the robot was, as the recording tells viewers."""

    def __init__(self, recording: Recording, loaded: LoadedMission) -> None:
        body = loaded.loaded_robot.profile.body
        names = [wheel.name for wheel in body.wheels]
        self._radius_m = body.wheel_radius
        pipe = loaded.pipe
        self._walls = tuple(Route(pipe).walls(pipe.diameter / 2)) if pipe is not None else ()
        self._times: list[float] = []
        self._points: list[tuple[Place, ...]] = []
        self.known = False
        for shown in recording.shown(_PLACES):
            self.known = bool(shown.content.get("known"))
            self._times.append(shown.at_s)
            self._points.append(
                tuple((shown.content[f"{n}_x_m"], shown.content[f"{n}_y_m"]) for n in names)
            )

    def at(self, time_s: float) -> Truth | None:
        """The newest place; None where none was told."""
        number = bisect_right(self._times, time_s) - 1
        if number < 0:
            return None
        return Truth(self._points[number], self._radius_m, self._walls, 0.0)
