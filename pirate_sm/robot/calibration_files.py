"""Write, find, check and apply the dated calibration files with the zeros of joints."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from math import degrees, radians
from pathlib import Path
from typing import Annotated

from platformdirs import user_config_path
from pydantic import Field

from pirate_sm.core.documents import Problems, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.fields import Angle, Date, Format, Frozen, Name
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedRobot, validate
from pirate_sm.core.on_disk import is_folder, listed, replace_file
from pirate_sm.core.robot import RobotSpec

LARGEST_ZERO_RAD = radians(30)
"""A larger zero means a slipped magnet, which a calibration must not hide."""

_FILE = re.compile(r"calibration-(\d{4}-\d{2}-\d{2})\.yaml")


class Calibration(Frozen):
    """The zeros of one robot's joints, measured on one day.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        date: Date of the measurement.
        port: Port of the robot.
        zeros: The reading of each joint's sensor when the joint is at zero; it is subtracted from
            each reading.
    """

    format: Format
    robot: Name
    date: Date
    port: str = ""
    zeros: Annotated[dict[Name, Angle], Field(min_length=1)]


def find_calibration(robot: LoadedRobot) -> Path | None:
    """Return the path of this robot's newest calibration; None if there is none.

    It is beside the profile, or in the user's folder if the profile's is read-only.
    """
    found = [
        (match[1], -place, folder / each.name)
        for place, folder in enumerate(_folders(robot))
        if is_folder(folder)
        for each in listed(folder)
        if (match := _FILE.fullmatch(each.name))
    ]
    return max(found)[2] if found else None


def load_calibration(path: Path, robot: LoadedRobot) -> Calibration:
    """Return the robot's calibration from this file.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    document = read_document(path)
    calibration = validate(document, Calibration)
    problems = Problems(document)
    if calibration.robot != robot.profile.robot:
        message = f"this is the calibration of '{calibration.robot}'"
        problems.add("calibration.robot", ("robot",), message, expected=robot.profile.robot)
    dated = _FILE.fullmatch(path.name)
    if dated and dated[1] != calibration.date:
        message = f"the file's name says {dated[1]}, this says {calibration.date}"
        problems.add("calibration.date", ("date",), message)
    joints = joints_of(robot)
    for name, zero in calibration.zeros.items():
        if name not in joints:
            problems.add_unknown(
                "calibration.joint", ("zeros", name), "joint", name, joints, key=True
            )
        if abs(zero) > LARGEST_ZERO_RAD:
            most = f"at most {degrees(LARGEST_ZERO_RAD):g} deg either way"
            message = f"{degrees(zero):z.1f} deg is too far from zero to be calibrated away"
            problems.add("calibration.zero", ("zeros", name), message, expected=most)
    problems.raise_errors()
    return calibration


def newest_calibration(robot: LoadedRobot) -> Calibration | None:
    """Return the newest calibration of this robot; None if there is none.

    Raises:
        LoadError: Its file has faults.
    """
    path = find_calibration(robot)
    return None if path is None else load_calibration(path, robot)


def joints_of(robot: LoadedRobot) -> tuple[str, ...]:
    """Return the joints whose zeros can be calibrated: those with a position loop of ours.

    A board with its own controller keeps its own zero.
    """
    measured = {
        channel.signal
        for board in robot.profile.boards
        if board.fitted and board.channels_fitted
        for channel in board.channels
    }
    return tuple(joint.name for joint in robot.profile.body.joints if joint.name in measured)


def with_zeros(robot: RobotSpec, zeros: Mapping[str, float]) -> RobotSpec:
    """Return the robot with these zeros, rad by signal, subtracted from its sensor readings."""
    names = robot.vocabulary.numbers
    boards = {
        number: replace(
            board,
            zeros=tuple(
                (target, zeros[names[target]])
                for _, target, _ in board.channels
                if names[target] in zeros
            ),
        )
        for number, board in robot.boards.items()
    }
    return replace(robot, boards=boards)


def summary(calibration: Calibration) -> str:
    """Return a one-line summary of the applied zeros."""
    zeros = ", ".join(f"{name} {degrees(z):+z.1f} deg" for name, z in calibration.zeros.items())
    return f"joint zeros of {calibration.date} applied: {zeros}"


def keep_calibration(calibration: Calibration, robot: LoadedRobot) -> Path:
    """Write the calibration to its file and return its path.

    Raises:
        UsageError: None of the folders is writable.
    """
    text = _text(calibration)
    reason = ""
    for folder in _folders(robot):
        path = folder / f"calibration-{calibration.date}.yaml"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            replace_file(path, text.encode())
            return path
        except OSError as error:
            reason = reason or f"{shown(folder)}: {error.strerror}"
    raise UsageError(f"the calibration cannot be written, {reason}")


def _folders(robot: LoadedRobot) -> tuple[Path, Path]:
    users = user_config_path("pirate_sm", appauthor=False) / "calibrations"
    return robot.folder, users / robot.profile.robot


def _text(calibration: Calibration) -> str:
    zeros = "".join(f"  {name}: {degrees(z):z.3f} deg\n" for name, z in calibration.zeros.items())
    port = calibration.port.replace("\\", "\\\\").replace('"', '\\"')
    return (
        "# What each joint's sensor shows when the robot is straight; it is subtracted.\n"
        "# Measured with `pirate calibrate`. The newest file counts; without any, nothing is\n"
        "# subtracted.\n"
        f"format: {calibration.format}\n"
        f"robot: {calibration.robot}\n"
        f"date: {calibration.date}\n"
        f'port: "{port}"\n'
        f"zeros:\n{zeros}"
    )
