"""`pirate camera survey`: finds where the camera hangs over its setup."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli.commands.camera_pictures import find_camera, opened, refuse_shipped
from pirate_sm.cli.options.cameras import SurveyOptions
from pirate_sm.cli.output.files import write_file
from pirate_sm.errors import UsageError
from pirate_sm.loading.camera_text import pose_line, with_pose
from pirate_sm.model.camera import Camera
from pirate_sm.model.camera_source import SyntheticSource
from pirate_sm.visible import visible
from pirate_sm.vision.lens import LensModel
from pirate_sm.vision.surveying import KnownPlace, known_points, known_tags, survey

UNKNOWN = 1


def survey_camera(options: SurveyOptions) -> int:
    """Print where the camera hangs and write it into its file; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: Its lens is unknown, there is no picture, it shows a tag twice, or the file
            cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.write:
        refuse_shipped(path)
    if camera.lens is None:
        raise UsageError("the lens is unknown: measure it first with `pirate camera calibrate`")
    if camera.setup.tags is None and not camera.setup.points:
        raise UsageError("the setup has neither tags nor points: put them into the camera's file")
    found = survey(LensModel(camera.lens), _known(camera, path, options.images))
    if isinstance(found, str):
        print(visible(f"nothing is written: {found}"))
        return UNKNOWN
    for name, off_px in found.each_px.items():
        print(f"  {name:<10} off by {off_px:.1f} px")
    print(f"{len(found.each_px)} known places, off by {found.rms_px:.2f} px (rms)")
    print(pose_line(found.pose))
    if options.write:
        write_file(path, with_pose(path, found.pose))
        print(visible(f"written into {path}"))
    return 0


def _known(camera: Camera, path: Path, images: str | None) -> dict[str, KnownPlace]:
    """Return the known places of the setup; the camera's file says where points are seen."""
    if camera.setup.tags is None:
        return known_points(camera)
    if isinstance(camera.source, SyntheticSource) and images is None:
        raise UsageError("a synthetic camera hangs where its file says: give pictures (--images)")
    with opened(camera, path, images) as (_, frame):
        return known_tags(camera, frame)
