from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import hypot
from pathlib import Path

from pirate_sm.recording.reader import read_recording
from pirate_sm.recording.reloading import recorded_mission
from pirate_sm.recording.replay import rerun
from pirate_sm.report.gathering import About, gather
from pirate_sm.report.model import Report
from pirate_sm.report.scene import MOST_POSES, Poses


def test_of_many_poses_some_stay_evenly_and_the_last_one():
    poses = Poses(true=True)
    for number in range(3 * MOST_POSES + 1):
        poses.add(0.1 * number, ((0.0, 0.0),))

    thin = poses.thinned()

    assert MOST_POSES / 2 < len(thin.times_s) <= MOST_POSES + 1
    assert (thin.times_s[0], thin.times_s[-1]) == (0.0, poses.times_s[-1])


def test_without_truth_joints_and_odometer_say_where_the_robot_is(
    recording: Callable[[str], Path], report: Callable[[str], Report]
) -> None:
    run, known = read_recording(recording("bend")), report("bend").scene
    with recorded_mission(run.header) as loaded:
        found = gather(loaded, About("somewhere", nominal=False), rerun(run, loaded), None)
        free = replace(loaded, pipe=None)
        adrift = gather(free, About("somewhere", nominal=False), rerun(run, free), None)

    assert known is not None
    assert found.scene is not None
    assert found.scene.source == "reckoned"
    assert any("odometer" in line for line in found.warnings)
    # It slips by some centimetres in all; that is what the warning is about.
    one, other = known.poses[-1][0], found.scene.poses[-1][0]
    assert hypot(one[0] - other[0], one[1] - other[1]) < 0.12
    assert adrift.scene is not None
    assert adrift.scene.walls == ()
