"""Read camera files, check what the models cannot, and put measured values into their text."""

from __future__ import annotations

import re
from itertools import combinations
from math import asin, cos, degrees, dist, sqrt
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.core.documents import Document, Problems, Severity, read_document
from pirate_sm.core.documents import Path as At
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import validate
from pirate_sm.core.models import Profile
from pirate_sm.core.spelling import nearest
from pirate_sm.robot.camera import (
    FEWEST_POINTS,
    Camera,
    CameraPose,
    DeviceSource,
    Lens,
    Marker,
    RobotTags,
    TagFamily,
    UrlSource,
)
from pirate_sm.robot.part_names import BY_CAMERA, BY_SOCKET

# --- reading --------------------------------------------------------------------------------------


_NUMBERS: dict[TagFamily, int] = {"aruco_4x4_50": 50, "apriltag_36h11": 587}

_FEWEST_PIXELS = 6
"""Squares along the side of a tag of the coarsest family, with its border."""


def load_camera(
    path: Path, *, posed: bool = True, profile: Profile | None = None
) -> tuple[Camera, Document]:
    """Return the camera in a file, and the file's document.

    Args:
        path: The file.
        posed: Whether lens and pose are used; those that are to be measured may still be wrong.
        profile: The robot that it looks at; None if that is not known.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    document = read_document(path)
    camera = validate(document, Camera)
    problems = Problems(document)
    _check_numbers(camera, problems)
    _check_overlaps(camera, problems)
    _check_points(camera, problems)
    if profile is not None:
        check_robot_seen(camera, profile, problems)
    if posed:
        _check_lens(camera, problems)
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


def _check_overlaps(camera: Camera, problems: Problems) -> None:
    """Report tags of the setup that cover each other, and two in the middle of one module."""
    setup, robot = camera.setup, camera.robot
    size_m, on = setup.size or 0.0, robot.on if isinstance(robot, RobotTags) else {}
    tagged: list[tuple[At, str, str]] = [
        (("setup", "at", two), one, two)
        for one, two in combinations(setup.at, 2)
        if all(abs(a - b) < size_m for a, b in zip(setup.at[one], setup.at[two], strict=True))
    ]
    tagged += [(("robot", "on", b), a, b) for a, b in combinations(on, 2) if on[a] == on[b]]
    for path, one, two in tagged:
        message = f"tag {two} covers tag {one}, which is at the same place"
        problems.add("camera.tag", path, message)


def _check_lens(camera: Camera, problems: Problems) -> None:
    """Report a lens whose axis meets no picture of this size."""
    lens, (width, height) = camera.lens, camera.source.size
    if lens is None or (0 <= lens.centre[0] < width and 0 <= lens.centre[1] < height):
        return
    message = f"the axis of the lens is outside of the picture of {width} × {height}"
    expected = "the `size` at which the lens was calibrated"
    problems.add("camera.lens", ("lens", "centre"), message, expected=expected)


def check_robot_seen(
    camera: Camera, profile: Profile, problems: Problems, severity: Severity = Severity.ERROR
) -> None:
    """Report what a camera looks for, or reports, and this robot does not have."""
    marks, name = camera.marks, profile.robot
    modules = {link.module: link.length for link in profile.body.links}
    at: At = ("robot", "marker") if isinstance(marks, Marker) else ("robot",)
    paths = [(*at, "on")] if isinstance(marks, Marker) else [(*at, "on", n) for n in marks.on]
    names: list[tuple[At, str, str, list[str]]] = [
        (path, on, "module", [*modules]) for path, on in zip(paths, camera.modules, strict=True)
    ]
    if camera.speed is not None:
        names.append((("speed",), camera.speed, "outside signal", [*profile.outside]))
    if marks.size > max(modules.values()):
        message = f"this is longer than every module of {name}"
        problems.add("camera.robot", (*at, "size"), message, severity=severity)
    for path, wanted, kind, known in names:
        if wanted not in known:
            message, close = f"{name} has no {kind} '{wanted}'", nearest(wanted, known) or ""
            expected = ", ".join(known) or f"no {kind} at all"
            problems.add("camera.robot", path, message,
                         expected=expected, suggestion=close, severity=severity)  # fmt: skip


def _check_pose(camera: Camera, problems: Problems) -> None:
    """Report a camera that hangs no higher than what is on the robot, or looks up from there."""
    pose = camera.setup.pose
    if pose is None:
        return
    height_m = camera.marks.height
    if pose.at[2] <= height_m:
        message = (
            f"the camera hangs at {pose.at[2]:g} m, and what it looks for is at {height_m:g} m"
        )
        problems.add("camera.pose", ("setup", "pose", "at"), message)
    lens, size_m, places = camera.lens, camera.setup.size, camera.setup.at.values()
    if lens is not None and size_m is not None:
        pixels = max(lens.f) * size_m / max(min(dist(pose.at, each) for each in places), size_m)
        if pixels < _FEWEST_PIXELS:
            message = f"no tag of the setup is larger than {pixels:.2g} pixels from there"
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
    if isinstance(camera.marks, RobotTags):
        return
    low, high = camera.marks.hsv
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


# --- writing --------------------------------------------------------------------------------------


_LENS = re.compile(r"^lens:.*\n(?:[ \t]+.*\n)*", re.MULTILINE)
_SETUP = re.compile(r"^setup:[ \t]*(?:#.*)?\n", re.MULTILINE)
_POSE = re.compile(r"^([ ]+)pose:.*\n(?:\1[ \t]+.*\n)*", re.MULTILINE)


def lens_line(lens: Lens) -> str:
    """Return the line that gives a camera this lens."""
    f, centre = (f"[{x:.2f}, {y:.2f}]" for x, y in (lens.f, lens.centre))
    k = ", ".join(f"{each:.6g}" for each in lens.k)
    return f"lens: {{model: {lens.model}, f: {f}, centre: {centre}, k: [{k}]}}"


def pose_line(pose: CameraPose) -> str:
    """Return the line that gives a setup this pose of its camera."""
    at = ", ".join(f"{1000 * each:.1f} mm" for each in pose.at)
    turn = ", ".join(f"{degrees(each):z.3f} deg" for each in pose.turn)
    return f"pose: {{at: [{at}], turn: [{turn}]}}"


def with_lens(path: Path, lens: Lens) -> str:
    """Return the text of a camera file with this lens instead of its own.

    Raises:
        LoadError: The file is no camera.
        UsageError: It cannot be changed line by line.
    """
    text, line = _text(path), f"{lens_line(lens)}\n"
    if _LENS.search(text):
        return _LENS.sub(line, text, count=1)
    return re.sub(r"^setup:", f"{line}setup:", _block_like(text, path, line), count=1, flags=re.M)


def with_pose(path: Path, pose: CameraPose) -> str:
    """Return the text of a camera file with this pose instead of its own.

    Raises:
        LoadError: The file is no camera.
        UsageError: It cannot be changed line by line.
    """
    text, line = _text(path), f"  {pose_line(pose)}\n"
    opened = _SETUP.search(_block_like(text, path, line))
    if opened is None:
        raise _by_hand(path, line)
    before, setup = text[: opened.end()], text[opened.end() :]
    end = re.search(r"^\S", setup, re.MULTILINE)
    inside, behind = (setup[: end.start()], setup[end.start() :]) if end else (setup, "")
    if _POSE.search(inside):
        return before + _POSE.sub(rf"\g<1>{line.strip()}\n", inside, count=1) + behind
    indent = re.match(r"(?:[ \t]*#.*\n|[ \t]*\n)*([ ]+)", inside)
    return f"{before}{indent[1] if indent else '  '}{line.strip()}\n{inside}{behind}"


def _text(path: Path) -> str:
    text = load_camera(path, posed=False)[1].text
    return text if text.endswith("\n") else f"{text}\n"


def _block_like(text: str, path: Path, line: str) -> str:
    """Return a text in which each key has a line of its own.

    Raises:
        UsageError: It is written in braces.
    """
    if not re.search(r"^setup:", text, re.MULTILINE):
        raise _by_hand(path, line)
    return text


def _by_hand(path: Path, line: str) -> UsageError:
    return UsageError(f"{shown(path)} is written in braces: put in by hand {line.strip()}")
