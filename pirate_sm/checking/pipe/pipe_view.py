"""A mission in its pipe as seen by the rules: pieces of the pipe, and places in files."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.pipe.usual_course import UsualCourse
from pirate_sm.geometry.piece import Piece
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.problems import Path, Place
from pirate_sm.loading.yaml.document import Document
from pirate_sm.model.pipe import Pipe


@dataclass(frozen=True)
class PipeView:
    """A mission in its pipe.

    Attributes:
        loaded: The mission.
        pipe: Its pipe.
        course: The course of the mission without failures.
        fit: The robot in the pipe.
    """

    loaded: LoadedMission
    pipe: Pipe
    course: UsualCourse
    fit: Fit

    def piece_behind(self, leading: int) -> Piece | None:
        """Return the piece behind the first bend for a robot with this leading part."""
        wheels, pieces = self.fit.profile.body.wheels, self.fit.route.pieces
        part, first = self.fit.robot.parts[leading], pieces.index(self.first_piece)
        step = 1 if part == wheels[0].part else -1 if part == wheels[-1].part else 0
        return pieces[first + step] if step and 0 <= first + step < len(pieces) else None

    @property
    def first_piece(self) -> Piece:
        """Return the piece in which the robot starts."""
        middle = self.pipe.start_of(self.fit.stretched_m) - self.fit.stretched_m / 2
        return self.fit.route.piece_at(middle)

    @property
    def start_path(self) -> Path:
        """Return the path of the robot's start position in the pipe, or of the first piece."""
        return ("start", "at") if self.pipe.start is not None else ("segments", 0)

    @property
    def pipe_document(self) -> tuple[Document, Path]:
        """Return the document that contains the pipe, and the pipe's path in it."""
        inline = isinstance(self.loaded.mission.pipe, Pipe) and (
            self.loaded.pipe is self.loaded.mission.pipe
        )
        return self.loaded.documents[-1], ("pipe",) if inline else ()

    def finding_in_pipe(self, path: Path, code: str, message: str) -> Finding:
        """Return a finding at a part of the pipe's description."""
        document, prefix = self.pipe_document
        place = document.place_of((*prefix, *path))
        return at(document, place, code, message)

    def place_of_step(self, text: str) -> Place:
        """Return the place of a step, from `file:line:col`."""
        if not text:
            return Place(self.loaded.documents[0].name)
        file, line, column = text.rsplit(":", 2)
        return Place(file, int(line), int(column))

    def document(self, name: str) -> Document:
        """Return the file of this name."""
        return next(each for each in self.loaded.documents if each.name == name)


def mm(length_m: float) -> str:
    """Return a length in mm for messages."""
    return f"{length_m * 1000:.4g} mm"
