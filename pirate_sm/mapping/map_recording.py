"""Map the pipe of a recorded run."""

from __future__ import annotations

from math import isfinite

from pirate_sm.detectors.word_timing import words_of
from pirate_sm.errors import RecordingError
from pirate_sm.mapping.legs import Map
from pirate_sm.mapping.looks import looks
from pirate_sm.mapping.mapper import Mapper
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.replay.recorded_mission import recorded_robot_files, robot_as_recorded


def mapped(recording: Recording) -> Map:
    """Return the map of the pipe that a robot has driven through.

    Of the recording it reads the robot's files, the frames of its boards, the detector's words, its
    states and its setpoints; neither truth, nor the pipe's file, nor reports from outside.

    Raises:
        RecordingError: The recording is damaged, its robot cannot be loaded any more, or no wheel
            angles were reported, as in a trace.
    """
    loaded = recorded_robot_files(recording.header)
    robot = robot_as_recorded(loaded, recording.header)
    mapper = Mapper(robot, words_of(loaded.profile))
    for look in looks(mapper.robot, recording.steps(), recording.origin_s):
        mapper.look(look)
    found = mapper.finish()
    if not isfinite(found.legs[0].from_m):
        raise RecordingError("nothing to map: the recording shows no angle of any wheel")
    return found
