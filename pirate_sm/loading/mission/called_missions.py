"""Read the missions that a mission calls, each once, and count their instructions."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path as FilePath

from pirate_sm.errors import PirateError
from pirate_sm.loading import library, references
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.mission.scope import Scope, Source
from pirate_sm.loading.problems import LoadError, Path
from pirate_sm.loading.yaml.document import Document, read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model import mission as model

DEEPEST_CALL = 16


@dataclass
class Calls:
    """The files of missions that are called, as far as they are known.

    Attributes:
        files: Every file that was read.
    """

    files: dict[FilePath, Document] = field(default_factory=dict)
    _known: dict[FilePath, Source] = field(default_factory=dict)
    _lengths: dict[FilePath, int] = field(default_factory=dict)

    def least_length(self, source: Source, calls: frozenset[FilePath] = frozenset()) -> int:
        """Return the least number of instructions of a mission, each repeat counted once.

        Each file is looked at once, however often it is called: calls that double thirty times
        over are counted at once and would take an age to be written out.
        """
        if source.path in calls:
            return 0  # a circle, which is said where it is called
        if source.path not in self._lengths:
            inner = len(source.mission.ends)
            for phase in source.mission.phases.values():
                inner += 1 + bool(phase.wait)
                for step, _ in model.every_step(phase.do):
                    inner += not isinstance(step, model.RepeatStep)
                    if isinstance(step, model.CallStep):
                        called = self._quietly(step.call, source.path.resolve().parent)
                        if called is not None:
                            inner += self.least_length(called, calls | {source.path})
            self._lengths[source.path] = inner
        return self._lengths[source.path]

    def source(self, name: str, scope: Scope, path: Path) -> Source | None:
        """Return the called mission, read once; None after reporting why it cannot be used."""
        folder = scope.source.path.resolve().parent
        try:
            found = self._read(name, folder)
        except LoadError as error:
            references.tell(
                error, library.find_mission(name, folder), references.MISSION, path, scope.problems
            )
            return None
        except PirateError as error:
            scope.problems.add(references.code_of(error, "mission.call"), path, str(error))
            return None
        if found.path in scope.calls:
            chain = " → ".join(each.stem for each in (*scope.calls, found.path))
            scope.problems.add("mission.recursion", path, f"a mission cannot call itself: {chain}")
            return None
        if len(scope.calls) >= DEEPEST_CALL:
            scope.problems.add("mission.depth", path, f"calls are nested more than {DEEPEST_CALL}")
            return None
        return found

    def _quietly(self, name: str, folder: FilePath) -> Source | None:
        """Return the mission that a file in this folder calls; None where it cannot be used."""
        try:
            return self._read(name, folder)
        except (LoadError, PirateError):
            return None  # which is said where it is called

    def _read(self, name: str, folder: FilePath) -> Source:
        file = references.followed(library.find_mission(name, folder), folder).resolve()
        if file not in self._known:
            document = read_document(file, shown(file))
            self.files[file] = document
            self._known[file] = Source(validate(document, model.Mission), document, file)
        return self._known[file]


def robot_of(source: Source) -> FilePath | str:
    """Return the folder of a mission's robot; different paths may lead to one."""
    try:
        return library.find_robot(source.mission.robot, source.path.resolve().parent)
    except PirateError:
        return source.mission.robot
