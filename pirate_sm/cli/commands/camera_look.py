"""`pirate camera look`: shows what is found in a picture of the camera."""

from __future__ import annotations

from collections.abc import Iterator
from glob import glob
from math import degrees
from pathlib import Path

from pirate_sm.cli.commands.camera_pictures import find_camera, one_picture
from pirate_sm.cli.options.cameras import LookOptions
from pirate_sm.cli.output.files import refuse_losses, write_bytes
from pirate_sm.errors import UsageError
from pirate_sm.model.camera import Camera, RobotTags
from pirate_sm.model.sighting import Sighting
from pirate_sm.visible import visible
from pirate_sm.vision.annotating import annotated
from pirate_sm.vision.opencv import cv2
from pirate_sm.vision.seeing import eye_of

UNSEEN = 1


def look(options: LookOptions) -> int:
    """Print what is found, and write the picture with it; return the exit code.

    Raises:
        LoadError: A file has faults.
        UsageError: The camera is not calibrated or surveyed, or gives no picture, or the picture
            cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.output:
        # Path.glob takes no absolute pattern.
        inputs = [path, *map(Path, glob(options.images or ""))]  # noqa: PTH207
        refuse_losses([options.output], inputs=inputs, overwrite=options.overwrite)
    eye = eye_of(camera)
    frame = one_picture(camera, path, options.images, options.robot, options.pipe)
    sighting = eye.see(frame, 0.0)
    for line in _lines(camera, sighting):
        print(visible(line))
    if options.output:
        _write(options.output, annotated(eye, frame, sighting))
        print(visible(str(options.output)))
    return 0 if sighting.marks else UNSEEN


def _lines(camera: Camera, sighting: Sighting) -> Iterator[str]:
    for mark in sighting.marks:
        x, y = (1000 * each for each in mark.place_m)
        turned = "" if mark.heading_rad is None else f", {degrees(mark.heading_rad):z6.1f} deg"
        yield f"  {mark.on:<12} x {x:7.1f} mm, y {y:7.1f} mm{turned}"
    wanted = len(camera.robot.on) if isinstance(camera.robot, RobotTags) else 1
    yield f"{len(sighting.marks)} of {wanted} marks of the robot are seen"
    if sighting.rms_px is not None:
        yield f"the setup's tags are {sighting.rms_px:.1f} px off the survey (rms)"
    yield f"spread of gray {sighting.gray_spread:.0f} of 255"


def _write(place: Path, frame: object) -> None:
    if place.suffix.lower() not in (".png", ".jpg", ".jpeg"):
        raise UsageError(f"'{place}': expected a name that ends in .png or .jpg")
    made, content = cv2.imencode(place.suffix, frame)
    if not made:
        raise UsageError(f"'{place}' cannot be written: the picture has no such form")
    write_bytes(place, content.tobytes())
