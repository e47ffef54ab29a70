"""Read camera files, and check what the models cannot."""

from __future__ import annotations

from math import asin, cos, degrees, sqrt
from pathlib import Path

from pirate_sm.detectors.known import BY_CAMERA, BY_SOCKET
from pirate_sm.loading import library
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.yaml.document import Document, read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.camera import FEWEST_POINTS, Camera, RobotTags, TagFamily
from pirate_sm.model.camera_source import DeviceSource, UrlSource

_NUMBERS: dict[TagFamily, int] = {"aruco_4x4_50": 50, "apriltag_36h11": 587}


def load_camera(path: Path, *, posed: bool = True) -> tuple[Camera, Document]:
    """Return the camera in a file, and the file's document.

    Args:
        path: The file.
        posed: Whether the pose is used; one that is to be surveyed may still be wrong.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    document = read_document(path)
    camera = validate(document, Camera)
    problems = Problems(document)
    _check_numbers(camera, problems)
    _check_points(camera, problems)
    if posed:
        _check_pose(camera, problems)
    _check_colours(camera, problems)
    problems.raise_errors()
    return camera, document


def opened_by(detector: str, folder: Path) -> str:
    """Return what a detector opens that no simulated robot needs; empty if nothing.

    Args:
        detector: Its name, with its argument.
        folder: Where a camera's file may be.

    Raises:
        LoadError: The file of its camera has faults.
        UsageError: There is no such camera.
    """
    kind, _, name = detector.partition(":")
    if kind == BY_CAMERA and name:
        camera, _ = load_camera(library.find_camera(name, folder))
        return "a live camera" if isinstance(camera.source, DeviceSource | UrlSource) else ""
    return "a socket" if kind == BY_SOCKET else ""


def _check_numbers(camera: Camera, problems: Problems) -> None:
    """Report numbers that the family of tags does not have, and those that stand for two tags."""
    setup, robot = camera.setup, camera.robot
    used = [(setup.tags, "setup", "at", number) for number in setup.at]
    if isinstance(robot, RobotTags):
        used += [(robot.tags, "robot", "on", number) for number in robot.on]
        if setup.tags == robot.tags:
            for number in setup.at.keys() & robot.on.keys():
                message = f"tag {number} is on the setup, too"
                problems.add("camera.tag", ("robot", "on", number), message, key=True)
    for family, *path in used:
        if family is not None and int(path[-1]) >= _NUMBERS[family]:
            message = f"the family {family} has no tag {path[-1]}"
            expected = f"0 to {_NUMBERS[family] - 1}"
            problems.add("camera.tag", tuple(path), message, expected=expected, key=True)


def _check_pose(camera: Camera, problems: Problems) -> None:
    """Report a camera that hangs no higher than what is on the robot, or looks up from there."""
    pose = camera.setup.pose
    if pose is None:
        return
    marks = camera.robot
    height_m = marks.height if isinstance(marks, RobotTags) else marks.marker.height
    if pose.at[2] <= height_m:
        message = (
            f"the camera hangs at {pose.at[2]:g} m, and what it looks for is at {height_m:g} m"
        )
        problems.add("camera.pose", ("setup", "pose", "at"), message)
    up = _axis_up(pose.turn)
    if up > _LEAST_UP:
        message = f"the camera looks up, {degrees(asin(min(up, 1.0))):.3g} deg above the plate"
        expected = "such as [180 deg, 0 deg, 0 deg], straight down"
        problems.add("camera.pose", ("setup", "pose", "turn"), message, expected=expected)


def _axis_up(turn: tuple[float, float, float]) -> float:
    """Return how far the axis of a lens points up, -1 to 1: the last element of Rodrigues' matrix.

    Rotations from the setup to the camera and back have that element in common.
    """
    angle_rad = sqrt(sum(each * each for each in turn))
    along = turn[2] / angle_rad if angle_rad else 0.0
    return cos(angle_rad) + (1 - cos(angle_rad)) * along * along


_LEAST_UP = 0.05
"""From which height of its axis on a camera looks away [decided]; a fisheye sees to its sides."""


def _check_colours(camera: Camera, problems: Problems) -> None:
    """Report limits of saturation and value that no colour is between; hue may go through red."""
    if isinstance(camera.robot, RobotTags):
        return
    low, high = camera.robot.marker.hsv
    for number, name in ((1, "saturation"), (2, "value")):
        if low[number] > high[number]:
            message = f"the lower {name}, {low[number]:g}, is above the upper one, {high[number]:g}"
            problems.add("camera.colour", ("robot", "marker", "hsv", 0, number), message)


def _check_points(camera: Camera, problems: Problems) -> None:
    """Report a setup from which the camera's pose can never be found."""
    setup = camera.setup
    known = max(len(setup.at), len(setup.points))
    if setup.pose is None and known < FEWEST_POINTS:
        path = ("setup", "at" if setup.at else "points")
        message = f"{known} known places are too few to find where the camera hangs"
        expected = f"at least {FEWEST_POINTS}, better 8 at two heights"
        problems.add("camera.points", path, message, expected=expected)
    width, height = camera.source.size
    for number, point in enumerate(setup.points):
        u, v = point.seen
        if not (0 <= u < width and 0 <= v < height):
            message = f"this is outside of the picture of {width} × {height}"
            problems.add("camera.points", ("setup", "points", number, "seen"), message)
