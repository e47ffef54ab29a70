"""Open the camera of a file: its sightings, live or in mission time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from pirate_sm.core.camera import Camera
from pirate_sm.core.camera import camera_source as kinds
from pirate_sm.core.errors import UsageError
from pirate_sm.robot.detectors.vision_detector import SightingSource
from pirate_sm.robot.vision.captures import open_capture
from pirate_sm.robot.vision.live_sightings import LiveSightings
from pirate_sm.robot.vision.paced_sightings import RecordedSightings, SyntheticSightings
from pirate_sm.robot.vision.seeing import eye_of
from pirate_sm.robot.vision.synthetic.picture import SyntheticPictures
from pirate_sm.robot.vision.synthetic.shown_scene import ShownScene


def open_sightings(
    camera: Camera, folder: Path, scene: Callable[[], ShownScene] | None = None, seed: int = 0
) -> SightingSource:
    """Return the sightings of a camera; it is open and has given a picture.

    Args:
        camera: What its file says.
        folder: The folder of the file, to which its paths refer.
        scene: Returns the simulated robot as it is now; for synthetic cameras.
        seed: Of the errors of a synthetic camera.

    Raises:
        UsageError: The camera cannot be opened, its pictures have another size, its lens or its
            place is unknown, or it is synthetic and no robot is simulated.
    """
    source, eye = camera.source, eye_of(camera)
    match source:
        case kinds.DeviceSource() | kinds.UrlSource():
            opened = partial(open_capture, source, folder)
            return LiveSightings(source, eye, camera.latency_s, opened)
        case kinds.FileSource() | kinds.ImagesSource():
            capture = open_capture(source, folder)
            return RecordedSightings(source, eye, camera.latency_s, capture)
        case kinds.SyntheticSource():
            if scene is None:
                raise UsageError(
                    f"the camera '{camera.camera}' is synthetic: it sees a simulated robot only"
                )
            pictures = SyntheticPictures(camera, eye.view, source.synthetic)
            return SyntheticSightings(eye, pictures, scene, seed)
