"""Map the pipe of a recorded run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile
from math import inf, isfinite

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import Observation
from pirate_sm.lab.mapping.legs import Map
from pirate_sm.lab.mapping.looks import looks
from pirate_sm.lab.mapping.mapper import Mapper
from pirate_sm.robot.detectors.word_timing import words_of
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.read.steps import RecordedStep
from pirate_sm.running.recording.replay.recorded_mission import (
    recorded_robot_files,
    robot_as_recorded,
)


def mapped(recording: Recording) -> Map:
    """Return the map of the pipe that a robot has driven through.

    Of the recording it reads the robot's files, the frames of its boards, the detector's words, its
    states and its setpoints, and quotes what a person has said of places; neither truth, nor the
    pipe's file, nor reports from outside. It ends at the first gap of a repaired recording, as the
    robot may have moved in it.

    Raises:
        RecordingError: The recording is damaged, its robot cannot be loaded any more, or no wheel
            angles were reported, as in a trace.
    """
    loaded = recorded_robot_files(recording.header)
    robot = robot_as_recorded(loaded, recording.header)
    waits = recording.header.detector == "odometry"
    mapper = Mapper(robot, words_of(loaded.profile), waits=waits)
    seen: list[str] = []
    for look in looks(mapper.robot, _overheard(recording, seen), recording.origin_s):
        mapper.look(look)
    found = mapper.finish()
    found.seen = seen
    for gap in recording.gaps[:1]:
        found.notes.append(
            f"nothing is known from {gap.from_s:.1f} s to {gap.until_s:.1f} s, so it ends there"
        )
    if not isfinite(found.legs[0].from_m):
        raise RecordingError("nothing to map: the recording shows no angle of any wheel")
    return found


def _overheard(recording: Recording, seen: list[str]) -> Iterator[RecordedStep]:
    """Yield the steps of the recording up to a gap; note what a person says in them."""
    after = min((gap.step for gap in recording.gaps), default=inf)
    for step in takewhile(lambda each: each.number < after, recording.steps()):
        if isinstance(step.event, Observation):
            seen.append(step.event.words)
        yield step
