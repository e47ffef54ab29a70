"""The documents' pictures of synthetic cameras: a simulated robot at some time of a run."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import pirate_sm
from pirate_sm.core import library
from pirate_sm.robot.camera import SyntheticSource
from pirate_sm.robot.camera_file import load_camera
from pirate_sm.robot.vision.opencv import Frame, cv2
from pirate_sm.robot.vision.seeing import annotated, eye_of
from pirate_sm.robot.vision.synthetic import SyntheticPictures, scene_in_pipe

SIZE = (960, 540)
QUALITY = 85


class Moment(NamedTuple):
    """A time of a run, as a camera sees it."""

    camera: str
    mission: str
    at_s: float


MOMENTS: Mapping[str, Moment] = MappingProxyType(
    {
        "camera_synthetic.jpg": Moment("synthetic", "mitre_bend", 15.0),
        "camera_setup_2.jpg": Moment("synthetic_setup_2", "exp_1d_round_pipe", 15.0),
    }
)


def seen(moment: Moment) -> Frame:
    """Return what the camera sees then, with what is found in it."""
    run = pirate_sm.run(moment.mission, seed=0)
    poses = run.poses()
    assert poses is not None, "the simulator knows where the robot is"
    pose = poses.points[bisect_right(poses.times_s, moment.at_s) - 1]
    camera, _ = load_camera(library.find_camera(moment.camera))
    eye = eye_of(camera)
    pipe = run.loaded.pipe
    assert pipe is not None, "the mission has a pipe"
    assert isinstance(camera.source, SyntheticSource)
    scene = scene_in_pipe(pose, run.loaded.loaded_robot.profile.body, pipe.route())
    pictures = SyntheticPictures(camera, eye.view, camera.source.synthetic)
    frame = pictures.picture(scene, 0)
    return cv2.resize(
        annotated(eye, frame, eye.see(frame, 0.0)), SIZE, interpolation=cv2.INTER_AREA
    )
