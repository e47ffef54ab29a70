"""Makes the report of a recording: its contents are collected while the run is replayed.

States, commands and faults come from the recording. Signals are not recorded, so the engine
computes them again from the recorded inputs.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import inf, isnan, nan
from pathlib import Path

from pirate_sm.core import effects as fx
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import PirateError
from pirate_sm.core.events import Event, SensorFrame
from pirate_sm.core.geometry import drawn_walls
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.clamp_forces import clamp_forces, in_words
from pirate_sm.running.recording.forecast_file import ForecastFile
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import Rerun, rerun, same
from pirate_sm.running.recording.viewers.viewer_messages import WheelPlacing
from pirate_sm.running.runtime.near_misses import NearMisses
from pirate_sm.running.runtime.phase_times import PhaseVisits
from pirate_sm.views.drawing.graph.highlight import RunPath, Stop, highlight
from pirate_sm.views.drawing.graph.mission_graph import mission_graph
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.report.charts import Measured, Samples, TravelChart, charts
from pirate_sm.views.report.contents import Report, Sentence
from pirate_sm.views.report.expectations import with_expectations
from pirate_sm.views.report.film_strip import photos_of
from pirate_sm.views.report.phase_lines import phase_lines
from pirate_sm.views.report.poses import (
    Arcs,
    Holding,
    Poses,
    ReckonedPath,
    SampledPose,
    scene_of,
    travel_of,
)
from pirate_sm.views.report.run_facts import About, about_run
from pirate_sm.views.report.stepping import SteppingNotes
from pirate_sm.views.report.story import RunEnding, RunFacts, Story, full_stop, summary
from pirate_sm.views.report.timeline import Timeline

# --- contents of a run --------------------------------------------------------------------------


_MOST_CAUSES = 3
"""The most failures that are shown: the last ones."""

_NEAR, _MOST_MISSES = 0.95, 3
"""From which share of its limit on a miss is shown, and of how many kinds: the nearest."""

_MOST_CLAMPS = 6
"""The most moments at which the interval of normal forces is shown: the last ones."""


def gather(
    loaded: LoadedMission, about: About, steps: Iterable[Rerun], seen: Poses | None
) -> Report:
    """Return the report of a run.

    Args:
        loaded: The mission of the run.
        about: Facts about the run.
        steps: The replayed steps.
        seen: The robot's true positions; None if unknown.
    """
    run = RunContents(loaded, about, estimates=seen is None)
    for again in steps:
        run.take(again)
    return run.report(seen)


class RunContents:
    """Collects the contents while a run is replayed.

    Args:
        loaded: The mission of the run.
        about: Facts about the run.
        estimates: Whether its position is estimated from its joints and its odometer.

    Attributes:
        about: Facts about the run.
    """

    def __init__(self, loaded: LoadedMission, about: About, *, estimates: bool) -> None:
        robot, profile = loaded.robot, loaded.loaded_robot.profile
        self._loaded, self.about = loaded, about
        self._state: EngineState | None = None
        self._signals = Samples(len(robot.vocabulary.numbers))
        self._setpoints = Samples(len(robot.slots))
        self._timeline = Timeline(robot.regions, nominal=about.nominal)
        descriptions = {name: each.description for name, each in loaded.mission.phases.items()}
        self._story = Story(descriptions, nominal=about.nominal)
        self._way, self._visits = RunPath(), PhaseVisits()
        self._stepping = SteppingNotes(loaded, tuple(about.files))
        self._holding = Holding(robot)
        self._clamped: deque[tuple[float, EngineState]] = deque(maxlen=_MOST_CLAMPS)
        self._forces: dict[float, str] = {}
        self._arcs: dict[SampledPose, Arcs] = {}
        self._near, self._origin_s = NearMisses(robot, loaded.program), 0.0
        self._drawn: tuple[tuple[Stop, ...], str] | None = None
        placing = WheelPlacing(profile, robot, loaded.pipe, about.first_wheel_m)
        self._following = ReckonedPath(placing)
        # Dead reckoning stays in the plane of the drawing.
        flat = loaded.pipe is None or bool(drawn_walls(loaded.pipe.route()))
        self._reckons = estimates and flat and not about.nominal
        self._at_s = 0.0
        self._doubt = ""
        self._ended: fx.Ended | None = None
        self._causes: list[Sentence] = []
        self._measured = {
            board.id: tuple({*board.numbers, *(n for n in (robot.odometry, robot.speed) if n >= 0)})
            if board.wheels
            else board.numbers
            for board in robot.boards.values()
        }

    def take(self, again: Rerun) -> None:
        """Take in one step of the run."""
        step, at_s = again.step, again.at_s
        self._at_s = max(self._at_s, at_s)
        if again.state is not None:
            self._look(again.state, step.event, at_s)
            self._origin_s = step.at_s - at_s
            if step.by == "start" or step.event is not None:
                self._near.look(again.state, step.event, step.at_s, step.effects)
        if not self._doubt and not same(step.effects, again.effects):
            self._doubt = (
                f"From {at_s:.2f} s on this version of the program differs from the "
                "one that recorded: signals may differ from what was known then."
            )
        if again.state is not None:
            self._note_cause(again.state.mission.cause, at_s)
            self._timeline.proofs = again.state.proofs
        control = 0 if self._state is None else self._state.robot.control
        name = self._loaded.robot.controls[control].name
        self._timeline.take(at_s, step.event, step.effects, name)
        self._story.take(at_s, step.event, step.effects)
        self._way.see(step.effects, at_s)
        self._visits.see(step.effects, at_s)
        self._stepping.take(at_s, step.effects, again.state)
        for effect in step.effects:
            if isinstance(effect, fx.Setpoints):
                self._setpoints.take(at_s, effect.values)
            elif isinstance(effect, fx.Ended):
                self._ended = effect

    def _look(self, state: EngineState, event: Event | None, at_s: float) -> None:
        """Note the signals and states at this time."""
        if self._state is None or isnan(state.robot.values[0]):  # at the start, or after a gap
            self._setpoints.take(at_s, state.robot.values)
        self._state = state
        measured = self._measured.get(event.board, ()) if isinstance(event, SensorFrame) else ()
        self._signals.take(at_s, state.sensing.shown, measured)
        if self._holding.look(state, at_s):
            self._clamped.append((at_s, state))
        if self._reckons:
            self._following.look(state, at_s)

    def _note_cause(self, cause: str, at_s: float) -> None:
        """Note the engine's cause of a failure and its phase."""
        if cause and (not self._causes or cause != self._causes[-1].text):
            self._causes.append(Sentence(at_s, cause, "trouble", self._timeline.phase))

    def report(self, seen: Poses | None, *, under_way: bool = False) -> Report:
        """Return the report of what was taken in so far.

        Args:
            seen: The robot's true positions; None if unknown.
            under_way: Whether the run may still continue.
        """
        loaded, about, until_s = self._loaded, self.about, self._at_s
        robot, profile = loaded.robot, loaded.loaded_robot.profile
        poses = seen or self._following.poses
        travel = travel_of(poses, loaded.pipe, self._arcs)
        sampled = self._signals, self._setpoints
        measured = Measured(profile, robot, *sampled, until_s, travel, self._bounds())
        ending = self._ending(under_way=under_way)
        lanes = self._timeline.lanes(until_s)
        held = self._holding.lanes(until_s)
        scene = scene_of(poses, profile, robot, loaded.pipe, *sampled, held)
        source = loaded.documents[0]
        return Report(
            title=loaded.mission.mission,
            outcome=ending.outcome,
            summary=summary(self._run_facts(ending, travel)),
            story=self._story.finish(ending),
            warnings=(*about.warnings, *self._doubts(seen, under_way=under_way)),
            duration_s=until_s,
            lanes=lanes,
            charts=charts(measured),
            scene=scene,
            diagram=self._diagram(),
            facts=about.facts,
            files=about.files,
            failures=self._failures(),
            doubts=() if about.nominal else tuple(self._look_twice()),
            source=Path(source.name).name,
            lines=phase_lines(source, loaded.mission),
            passages=self._visits.until(until_s),
            stepping=self._stepping.contents(),
        )

    def _diagram(self) -> str:
        """Return the mission with the path taken; it is drawn when that has changed."""
        stops = tuple(self._way.stops)
        if self._drawn is None or self._drawn[0] != stops:
            self._drawn = stops, svg(highlight(mission_graph(self._loaded.mission), stops))
        return self._drawn[1]

    def _bounds(self) -> str:
        """Return in words between which values the normal forces lay when clamps had closed."""
        for at_s, state in self._clamped:
            if at_s in self._forces:
                continue
            try:
                forces = clamp_forces(self._loaded, state, self.about.options)
            except PirateError as error:
                return f"Between which values they may lie is not shown: {error}."
            words = f"At {at_s:.2f} s: {', '.join(map(in_words, forces))}." if forces else ""
            self._forces[at_s] = words
        return " ".join(filter(None, (self._forces[at_s] for at_s, _ in self._clamped)))

    def _ending(self, *, under_way: bool) -> RunEnding:
        if self._ended is None:
            return RunEnding("running" if under_way else "unfinished", "", self._at_s)
        return RunEnding(self._ended.outcome, self._ended.message, self._at_s)

    def _failures(self) -> tuple[Sentence, ...]:
        """Return what made the run fail; the end itself if the engine names no cause."""
        if self._ended is None or self._ended.outcome not in ("failed", "fault"):
            return ()
        if not self._causes:
            return (Sentence(self._at_s, self._ended.message, "end"),)
        return tuple(self._causes[-_MOST_CAUSES:])

    def _run_facts(self, ending: RunEnding, travel: TravelChart | None) -> RunFacts:
        loaded, story, robot = self._loaded, self._story, self._loaded.robot
        odometer = nan
        if self._state is not None and robot.odometry >= 0 and not self.about.nominal:
            odometer = self._state.sensing.numbers[robot.odometry]
        moved = travel.distance.values[-1] if travel is not None and travel.true else None
        names = loaded.mission.mission, loaded.mission.description, robot.name
        ways_m = None if isnan(odometer) else odometer, moved
        return RunFacts(*names, self.about.where, ending, *ways_m, story.counts, story.faults)

    def _look_twice(self) -> Iterator[Sentence]:
        """Yield the waits that were over as they began, and the nearest misses, each kind once."""
        seen = set()
        for each in self._story.at_once:
            if (each.topic, each.text) not in seen:
                seen.add((each.topic, each.text))
                yield each
        misses = [each for each in self._near.nearest() if _NEAR <= each.share < 1.0]
        for miss in misses[:_MOST_MISSES]:
            yield Sentence(miss.at_s - self._origin_s, full_stop(miss.text), "trouble")

    def _doubts(self, seen: Poses | None, *, under_way: bool) -> tuple[str, ...]:
        doubts = [self._doubt] if self._doubt else []
        if self._state is None and not under_way:
            doubts.append(
                "Of the run itself nothing is in the recording, so there is nothing to show: it "
                "ends before the engine was started."
            )
        elif self.about.nominal:
            doubts.append("Nothing moved: commands ended by their nominal time.")
        elif seen is None and self._following.poses.times_s:
            doubts.append(
                "The position of the robot was unknown: it is drawn where its joints and its "
                "odometer take it to be. Slip is not in that."
            )
        return tuple(doubts)


# --- of a recording -----------------------------------------------------------------------------


def report_of(recording: Recording, forecast: ForecastFile | None = None) -> Report:
    """Return the report of a recorded run.

    Args:
        recording: The recording.
        forecast: What earlier runs say about it; None: nothing.

    Raises:
        RecordingError: The recording is damaged, or of a version that cannot be read any more.
    """
    with recorded_mission(recording.header) as loaded:
        about = about_run(recording.header, loaded, recording.notices)
        report = gather(
            loaded,
            about,
            rerun(recording, loaded, every_signal=True),
            known_poses(recording, loaded),
        )
    photos = photos_of(recording, report.lanes)
    gaps = tuple((gap.from_s, gap.until_s) for gap in recording.gaps)
    report = replace(report, recording=recording.sha256, photos=photos, gaps=gaps)
    return report if forecast is None else with_expectations(report, forecast)


def known_poses(recording: Recording, loaded: LoadedMission) -> Poses | None:
    """Return the robot's true positions from a simulator; None if they are unknown."""
    poses = Poses(true=True)
    add_known(poses, recording, loaded)
    return poses if poses.times_s else None


def add_known(poses: Poses, recording: Recording, loaded: LoadedMission) -> None:
    """Add the true positions that the recording has after the last of these."""
    since_s = poses.times_s[-1] if poses.times_s else -inf
    for placed in recorded_places(recording, loaded.loaded_robot.profile.body, since_s):
        if placed.known and placed.at_s > since_s:
            poses.add(placed.at_s, placed.wheels, placed.space)
