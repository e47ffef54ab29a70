"""Loads the mission of a recording, or its robot alone, from its recorded texts."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any

from pirate_sm.core.documents import Document, LoadError, parse_document
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.loading import LoadedMission, LoadedRobot, load_mission, load_robot, with_fitted
from pirate_sm.core.program import Wait
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.calibration_files import with_zeros
from pirate_sm.running.recording.format.header import RecordedFile, RunHeader
from pirate_sm.running.recording.format.json_values import resumption_from_text

_PROFILE = "profile.yaml"


@contextmanager
def recorded_mission(header: RunHeader) -> Iterator[LoadedMission]:
    """Yield the mission as it was run; its files are in a temporary folder until the block ends.

    Raises:
        RecordingError: This version cannot load the texts any more, or they cannot be written.
    """
    has_pipe = any(file.role == "pipe" for file in header.files)
    with ExitStack() as stack:
        with _failing("mission", header):
            folder = Path(stack.enter_context(TemporaryDirectory(prefix="recorded-")))
            mission, robot = _write(header, folder)
            loaded = load_mission(
                mission,
                robot=str(robot),
                pipe=str(folder / "pipe.yaml") if has_pipe else None,
                settings=header.parameters,
                start_phase=header.options.get("start_phase"),
                states=header.options.get("states"),
                fitted=recorded_fit(header),
            )
        yield as_recorded(loaded, header)


@contextmanager
def _failing(what: str, header: RunHeader) -> Iterator[None]:
    """Raise the RecordingError that says why this part of a recording cannot be loaded."""
    try:
        yield
    except OSError as error:
        raise RecordingError(
            "the files of the recording cannot be written into a temporary folder: "
            f"{error.strerror}; TMPDIR names another place"
        ) from None
    except (LoadError, UsageError) as error:
        raise RecordingError(
            f"the {what} in the recording, made with version {header.version}, cannot be "
            f"loaded any more: {error}"
        ) from None


def recorded_robot(header: RunHeader) -> RobotSpec:
    """Return the robot of a recording, with its polarity and joint zeros; nothing else is read.

    Raises:
        RecordingError: This version cannot load the texts any more, or they cannot be written.
    """
    return robot_as_recorded(recorded_robot_files(header), header)


def robot_as_recorded(loaded: LoadedRobot, header: RunHeader) -> RobotSpec:
    """Return a robot with the polarity and the joint zeros of a recording."""
    robot = loaded.mirrored if header.polarity == "mirrored" else loaded.normal
    return with_zeros(robot, dict(header.zeros)) if header.zeros else robot


def recorded_robot_files(header: RunHeader) -> LoadedRobot:
    """Return the robot of a recording as its files say.

    Raises:
        RecordingError: This version cannot load the texts any more, or they cannot be written.
    """
    with _failing("robot", header), TemporaryDirectory(prefix="recorded-") as folder:
        robot = load_robot(write_robot(header, Path(folder)))
        return with_fitted(robot, recorded_fit(header))


def recorded_fit(header: RunHeader) -> Document | None:
    """Return the file with fitted numbers of the run; None if it had none.

    Raises:
        LoadError: This version cannot read it.
    """
    fits = (parse_document(file.text, file.name) for file in header.files if file.role == "fit")
    return next(fits, None)


def as_recorded(loaded: LoadedMission, header: RunHeader) -> LoadedMission:
    """Return the mission with the file names, the joint zeros and the program of the run."""
    names = {
        document.name: file.name
        for document, file in zip(loaded.documents, header.files, strict=False)
    }
    instructions = tuple(_placed(each, names) for each in loaded.program.instructions)
    handlers = {each: tuple(_placed(it, names) for it in each) for each in loaded.program.handlers}
    in_force = tuple(handlers[each] for each in loaded.program.handlers)
    program = replace(loaded.program, instructions=instructions, handlers=in_force)
    for each in header.resumed:
        resumption = resumption_from_text(each.resumption)
        program = resumption.program(program) if resumption is not None else program
    named = replace(loaded, program=program)
    if not header.zeros:
        return named
    return replace(named, robot=with_zeros(loaded.robot, dict(header.zeros)))


def _placed(instruction: Any, names: Mapping[str, str]) -> Any:
    """Return the instruction with the file renamed in each of its ``place`` values."""
    changed: dict[str, Any] = {}
    if getattr(instruction, "place", ""):
        file, line, column = instruction.place.rsplit(":", 2)
        changed["place"] = f"{names.get(file, file)}:{line}:{column}"
    if isinstance(instruction, Wait):
        changed["triggers"] = tuple(_placed(each, names) for each in instruction.triggers)
    return instruction._replace(**changed) if changed else instruction


def _write(header: RunHeader, folder: Path) -> tuple[Path, Path]:
    """Write every text where the others refer to it.

    Returns:
        The mission's file and the robot's folder.
    """
    for file in header.files:
        if file.role == "pipe":
            (folder / "pipe.yaml").write_text(file.text, encoding="utf-8")
    mission = next(file for file in header.files if file.role == "mission")
    called = [file for file in header.files if file.role == "called"]
    written = _write_with(mission, Path(mission.path).name, called, folder / "missions")
    return written, write_robot(header, folder)


def write_robot(header: RunHeader, folder: Path) -> Path:
    """Write profile and chart below a folder, and return the folder of the profile."""
    profile = next(file for file in header.files if file.role == "profile")
    chart = next(file for file in header.files if file.role == "chart")
    return _write_with(profile, _PROFILE, [chart], folder / "robot").parent


def _write_with(
    file: RecordedFile, name: str, others: Sequence[RecordedFile], folder: Path
) -> Path:
    """Write a text and those that it refers to, by their path from it or by their name.

    It is so deep in the folder that ``../`` does not lead out of it.

    Args:
        file: The text.
        name: Name of its file.
        others: Those to which it refers.
        folder: The folder for all of them, which does not exist yet.

    Returns:
        Its file.
    """
    paths = {
        each.path: Path(os.path.relpath(_plain(each.path), _plain(file.path).parent))
        for each in others
        if each.path.startswith("shipped:") == file.path.startswith("shipped:")
    }
    deep = max((path.parts.count(os.pardir) for path in paths.values()), default=0)
    here = folder.joinpath(*["below"] * deep)
    texts = {(here / paths[each.path]).resolve(): each for each in others if each.path in paths}
    for each in others:
        texts.setdefault((here / Path(each.path).name).resolve(), each)
    for place, each in ((here / name, file), *texts.items()):
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(each.text, encoding="utf-8")
    return here / name


def _plain(path: str) -> PurePosixPath:
    return PurePosixPath("/", path.removeprefix("shipped:"))
