"""Makes the detector ``vision``: a camera over the setup, by its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.core.errors import Hint, UsageError, not_installed
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.registry import Plugin
from pirate_sm.robot import part_names
from pirate_sm.robot.camera import Camera, DeviceSource, RobotTags, SyntheticSource, UrlSource
from pirate_sm.robot.camera_file import load_camera
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.registry import Asked, Detecting, MakeDetector
from pirate_sm.robot.detectors.vision_detector import (
    CameraSight,
    OneMarker,
    Placing,
    SightingSource,
    Tags,
)

_INSTALLED = {"cv2", "numpy"}
"""The packages that the extra `vision` installs."""


def make(asked: Asked) -> Detecting:
    """Return the detector, with its camera still closed.

    Raises:
        LoadError: The camera's file has faults or does not fit the robot; holds all of them.
        UsageError: There is no such camera or no pipe, or the
            extra ``vision`` is not installed.
    """
    if not asked.argument:
        cameras = ", ".join(path.stem for path in library.cameras())
        raise UsageError(f"detector vision: name a camera, vision:NAME; there are {cameras}")
    if asked.pipe is None:
        hint = Hint(": give it with --pipe", ": give it with pipe='NAME'")
        raise UsageError("the detector vision needs to know the pipe", hint=hint)
    path = library.find_camera(asked.argument, Path.cwd())
    camera, _ = load_camera(path, profile=asked.profile)
    route = asked.pipe.route()
    links = _links(camera, asked.profile)
    odometry = None
    if asked.robot.odometry >= 0:
        odometry = Odometry(asked.profile, asked.robot, asked.pipe, asked.first_wheel_m)
    placing: Placing
    if isinstance(camera.robot, RobotTags):
        placing = Tags(asked.robot.body, route, links)
    elif odometry is None:
        message = f"the camera '{camera.camera}' sees one marker: the shape needs odometry"
        raise UsageError(f"{message}, and {asked.robot.name} has no signal of odometry_of")
    else:
        placing = OneMarker(route, next(iter(links.values())))
    opens = _opening(camera, path.parent, asked, asked.pipe)
    sight = CameraSight(
        asked.profile,
        asked.robot,
        route,
        opens,
        placing,
        odometry=odometry,
        live=isinstance(camera.source, DeviceSource | UrlSource),
        measures=camera.speed or "",
    )
    notice = f"detector: the camera {camera.camera}"
    return Detecting("vision", (sight,), (notice,), sight.truth, sight.view)


def _links(camera: Camera, profile: Profile) -> Mapping[str, int]:
    """Return the index of the link of each module that the camera looks for."""
    modules = [link.module for link in profile.body.links]
    return {name: modules.index(name) for name in camera.modules}


def _opening(
    camera: Camera, folder: Path, asked: Asked, pipe: Pipe
) -> Callable[[], SightingSource]:
    """Return what opens the camera.

    Raises:
        UsageError: The extra ``vision`` is not installed, or the camera is synthetic and the
            backend knows no robot to show.
    """
    try:
        from pirate_sm.robot.vision.sightings import open_sightings
    except ModuleNotFoundError as error:
        if error.name not in _INSTALLED:
            raise
        raise not_installed("the detector vision", error.name, "vision") from None
    from pirate_sm.robot.vision.synthetic import ShownScene, scene_in_pipe

    wheels, body, route = asked.wheels, asked.profile.body, pipe.route()
    if isinstance(camera.source, SyntheticSource) and wheels is None:
        message = f"the camera '{camera.camera}' is synthetic: it sees a simulated robot only"
        raise UsageError(message, hint=Hint(": use --backend sim", ": use backend='sim'"))

    def scene() -> ShownScene:
        assert wheels is not None, "only synthetic cameras ask for it"
        return scene_in_pipe(wheels(), body, route)

    return partial(open_sightings, camera, folder, scene, asked.seed)


DETECTOR: Plugin[MakeDetector] = Plugin(part_names.DETECTORS[part_names.BY_CAMERA], make)
