"""The header of a recording: the set-up of the run, with every text that it was made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

from pydantic import TypeAdapter

from pirate_sm import __version__
from pirate_sm.core import library
from pirate_sm.core.events import ALPHABET_VERSION
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.options import USUAL
from pirate_sm.running.recording.format.engine_topics import WireLayout

FORMAT = 2
"""Incremented when readers of recordings must change."""

READABLE_FORMATS = (1, 2)
"""Recordings of these are read: those of 1 all have messages for viewers."""

PROFILE = "pirate_sm"
"""The profile in the MCAP header of our recordings."""

RUN = "run.json"
FILES = "files/"
REPAIRED = "pirate_sm.repaired"
"""Name of the metadata in a recording that was cut short and repaired later."""

CHECKPOINT = "pirate_sm.checkpoint"
"""Name of the metadata before each piece with a checkpoint: its own offset in the file, and the
topics so far by their numbers. Readers that begin at the end of a file find it by its name."""

Role: TypeAlias = Literal["mission", "profile", "chart", "fit", "called", "pipe"]


@dataclass(frozen=True)
class RecordedFile:
    """A text file that the run was made from.

    Attributes:
        role: Its role; ``pipe`` is absent if the mission contains the pipe itself, ``fit`` (fitted
            numbers of motors) in most runs.
        name: Its name in messages.
        path: Its original path; that of a shipped file begins with ``shipped:``.
        sha256: Hash of the text, hexadecimal.
        attachment: Name of the attachment with the text.
        text: The text.
    """

    role: Role
    name: str
    path: str
    sha256: str
    attachment: str
    text: str = field(default="", repr=False)


@dataclass(frozen=True)
class ResumedRun:
    """A recording of a run that was cut off and is resumed.

    Attributes:
        name: Name of its file.
        sha256: Hash of its file, hexadecimal.
        last_step: Number of its last step.
        last_s: Time of that step by the engine's clock, s.
        resumption: What the mission resumes with, as JSON.
        said: What the operator has said about the robot, in words.
    """

    name: str
    sha256: str
    last_step: int
    last_s: float
    resumption: str
    said: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunHeader:
    """The header of a recording.

    Attributes:
        format: Version of the recording's format.
        alphabet: Version of events and effects.
        version: Version of this package.
        began: When the run began, ISO 8601 with the zone.
        mission: Name of the mission.
        robot: Name of the robot.
        polarity: ``normal`` or ``mirrored``.
        pipe: Name of the pipe; empty without one.
        backend: Name of the backend.
        nominal: Whether commands ended after their nominal duration.
        detector: Name of the detector.
        options: The run's options, with the seed and whether the mission was checked.
        parameters: Active values, as messages write them.
        zeros: Active joint zeros, rad by signal.
        regions: The state machines, in the order of states in effects.
        boards: Names of channels by the number of the board.
        slots: Name and unit of each setpoint.
        files: The texts.
        viewers: Whether it has messages for viewers; if not, it has samples, from which they can be
            made.
        resumed: The recordings that it resumes, the first run first; empty for most.
    """

    began: str
    mission: str
    robot: str
    polarity: str
    pipe: str
    backend: str
    nominal: bool
    detector: str
    options: Mapping[str, Any]
    parameters: Mapping[str, str]
    zeros: Mapping[str, float]
    regions: tuple[str, ...]
    boards: dict[int, tuple[str, ...]]
    slots: tuple[tuple[str, str], ...]
    files: tuple[RecordedFile, ...]
    viewers: bool = True
    resumed: tuple[ResumedRun, ...] = ()
    format: int = FORMAT
    alphabet: int = ALPHABET_VERSION
    version: str = __version__

    @property
    def layout(self) -> WireLayout:
        """Return the boards and setpoints of the robot."""
        return WireLayout(self.boards, self.slots)

    @property
    def fidelity(self) -> str:
        """Return how finely the simulator computed; it was usual before there was a choice."""
        return str(self.options.get("fidelity", USUAL))

    @property
    def coarser(self) -> tuple[str, ...]:
        """Return the fidelity if it was coarser than usual; otherwise nothing."""
        return () if self.fidelity == USUAL else (self.fidelity,)

    def to_json(self) -> dict[str, Any]:
        """Return the header as JSON data, without the texts."""
        data = asdict(self)
        for file in data["files"]:
            del file["text"]
        return data


def header_from_json(data: bytes, texts: Mapping[str, str]) -> RunHeader:
    """Return the header in the output of :meth:`RunHeader.to_json`.

    Args:
        data: The output of :meth:`RunHeader.to_json`, as text.
        texts: The texts by the name of their attachment.

    Raises:
        ValueError: The data is not a header.
        KeyError: A text is missing.
    """
    bare = TypeAdapter(RunHeader).validate_json(data)
    files = tuple(replace(file, text=texts[file.attachment]) for file in bare.files)
    return replace(bare, files=files)


def header_of(
    loaded: LoadedMission,
    *,
    backend: str,
    nominal: bool,
    detector: str,
    options: Mapping[str, Any],
    began: datetime,
    viewers: bool = True,
) -> RunHeader:
    """Return the header of a recording of this mission; arguments as in :class:`RunHeader`."""
    robot, names = loaded.robot, loaded.robot.vocabulary.numbers
    zeros = {names[target]: zero for each in robot.boards.values() for target, zero in each.zeros}
    return RunHeader(
        began=began.isoformat(),
        mission=loaded.mission.mission,
        robot=robot.name,
        polarity=robot.polarity,
        pipe=loaded.pipe_name,
        backend=backend,
        nominal=nominal,
        detector=detector,
        options=options,
        parameters=dict(loaded.parameters),
        zeros=zeros,
        regions=robot.regions,
        boards={
            board.id: tuple(channel.name for channel in board.channels)
            for board in loaded.loaded_robot.profile.boards
        },
        slots=tuple((slot.name, slot.unit) for slot in robot.slots),
        files=recorded_files(loaded),
        viewers=viewers,
    )


def recorded_files(loaded: LoadedMission) -> tuple[RecordedFile, ...]:
    """Return the texts that a mission was loaded from, in the order of its documents."""
    of_robot: tuple[Role, ...] = ("profile", "chart", "fit")
    robot = loaded.loaded_robot.documents
    mission, *others, pipe = loaded.documents
    roles: list[tuple[Role, Any]] = [("mission", mission), *zip(of_robot, robot, strict=False)]
    roles += [("called", document) for document in others[len(robot) :]]
    if pipe is not mission:
        roles.append(("pipe", pipe))
    found, shipped = [], library.shipped().resolve()
    for number, (role, document) in enumerate(roles):
        name, attachment = document.name, f"{FILES}{number}_{role}.yaml"
        where, sha256 = _place(Path(name), shipped), loaded.files[name]
        found.append(RecordedFile(role, name, where, sha256, attachment, document.complete_text))
    return tuple(found)


def _place(path: Path, shipped: Path) -> str:
    """Return the path of the file; for a shipped file it does not depend on the machine."""
    whole = path.resolve()
    if whole.is_relative_to(shipped):
        return f"shipped:{whole.relative_to(shipped).as_posix()}"
    return whole.as_posix()
