"""Pictures for the commands of `pirate camera`: of the camera, of files, or drawn."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.camera_file import load_camera
from pirate_sm.loading.pipe_file import load_pipe
from pirate_sm.loading.robot import load_robot
from pirate_sm.model.camera import Camera
from pirate_sm.model.camera_source import DeviceSource, ImagesSource, SyntheticSource
from pirate_sm.vision.captures import Capture, first_frame, open_capture
from pirate_sm.vision.picture_arrays import Frame
from pirate_sm.vision.seeing import eye_of
from pirate_sm.vision.synthetic.picture import SyntheticPictures
from pirate_sm.vision.synthetic.shown_scene import ShownScene, scene_in_pipe

_WARM_UP = 15
"""Pictures after which a camera has found its exposure."""


def find_camera(name: str) -> tuple[Camera, Path]:
    """Return the camera of this name or path, and its file; its pose may still be wrong.

    Raises:
        LoadError: The file has faults.
        UsageError: There is none.
    """
    path = library.find_camera(name, Path.cwd())
    return load_camera(path, posed=False)[0], path


def refuse_shipped(path: Path) -> None:
    """Raise UsageError for a file that belongs to this package."""
    if path.resolve() in {each.resolve() for each in library.cameras()}:
        raise UsageError(
            f"'{path.stem}' is a shipped camera: copy {path} into cameras/ as your own, or add"
            " --no-write"
        )


@contextmanager
def opened(camera: Camera, path: Path, images: str | None) -> Iterator[tuple[Capture, Frame]]:
    """Yield the opened pictures of a camera, or those in files, and the first of them.

    Raises:
        UsageError: They cannot be opened, or have another size than the camera's file says.
    """
    source, folder = camera.source, path.parent
    if images is not None:
        source, folder = ImagesSource(images=images, size=source.size), Path.cwd()
    capture = open_capture(source, folder)
    try:
        frame = first_frame(capture, source)
        if isinstance(source, DeviceSource):
            for _ in range(_WARM_UP):
                read = capture.read()
                frame = frame if read is None else read
        yield capture, frame
    finally:
        capture.close()


def one_picture(
    camera: Camera, path: Path, images: str | None, robot: str | None, pipe: str
) -> Frame:
    """Return a picture; a synthetic camera sees the robot at its start in a pipe.

    Raises:
        LoadError: The robot or the pipe has faults.
        UsageError: There is no picture.
    """
    if isinstance(camera.source, SyntheticSource) and images is None:
        pictures = SyntheticPictures(camera, eye_of(camera).view, camera.source.synthetic)
        return pictures.picture(_at_start(robot, pipe), 0)
    with opened(camera, path, images) as (_, frame):
        return frame


def _at_start(robot: str | None, pipe: str) -> ShownScene:
    """Return a straight robot at the start in a pipe."""
    folder = library.robots()[0] if robot is None else library.find_robot(robot, Path.cwd())
    body = load_robot(folder).profile.body
    found, _ = load_pipe(library.find_pipe(pipe, Path.cwd()))
    route = found.route()
    lengths = [link.length for link in body.links]
    front_m = found.start_of(sum(lengths))
    wheels = [(front_m - sum(lengths[:number]), 0.0) for number in range(len(lengths) + 1)]
    return scene_in_pipe(wheels, body, route)
