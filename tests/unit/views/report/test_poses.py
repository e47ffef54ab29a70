from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import hypot
from pathlib import Path

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import rerun
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.poses import MOST_POSES, Poses
from pirate_sm.views.report.recording_report import gather
from pirate_sm.views.report.run_facts import About


def test_of_many_poses_some_stay_evenly_and_the_last_one():
    poses = Poses(true=True)
    for number in range(3 * MOST_POSES + 1):
        poses.add(0.1 * number, ((0.0, 0.0),))

    thin = poses.thinned()

    assert MOST_POSES / 2 < len(thin.times_s) <= MOST_POSES + 1
    assert (thin.times_s[0], thin.times_s[-1]) == (0.0, poses.times_s[-1])


def test_of_a_very_long_run_no_more_poses_are_kept_and_the_newest_always_is(monkeypatch):
    monkeypatch.setattr("pirate_sm.views.report.poses._MOST_KEPT", 100)
    poses, most = Poses(true=True), 0
    for number in range(5_000):
        poses.add(0.1 * number, ((float(number), 0.0),))
        most = max(most, len(poses.times_s))
        assert (poses.times_s[-1], poses.points[-1]) == (0.1 * number, ((float(number), 0.0),))

    gaps = [after - before for before, after in pairwise(poses.times_s[:-1])]
    assert most <= 101
    assert poses.times_s[0] == 0.0
    assert len(poses.times_s) > 40
    assert max(gaps) < 3 * min(gaps)


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
