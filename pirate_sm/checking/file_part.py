"""What a check is asked for, and what the check of one file adds to its report."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from pirate_sm.checking.findings import (
    Finding,
    read,
    written,
)
from pirate_sm.checking.reports.check_report import (
    CheckedFile,
    Rehearsal,
    Rehearse,
)
from pirate_sm.core.documents import (
    Document,
    FileKind,
)

CheckOther: TypeAlias = Callable[[Path], tuple[Sequence[Document], Iterable[Finding]]]
"""Returns a file with those that it uses and what is wrong with them, or raises a `LoadError`."""


@dataclass(frozen=True)
class Wishes:
    """The options with which missions are checked, instead of their own settings.

    Attributes:
        robot: Name or path of a robot.
        pipe: Name or path of a pipe.
        usual_robot: Name or path of the robot of pipes that no mission here uses; None for the
            first one shipped.
        settings: Parameter values, for every mission that has the parameters.
        keep_going: Whether an internal error becomes a finding.
        counterexamples: The folder for counterexamples; None to write none.
        rehearse: Runs a mission in the simulator; None to run none.
        outside: Whether references may leave the project.
        others: Check files of the kinds that only layers above know; a kind without a check is
            not checked.
        other_findings: About files that are not checked here, such as the project's settings.
    """

    robot: str | None = None
    pipe: str | None = None
    usual_robot: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    keep_going: bool = True
    counterexamples: Path | None = None
    rehearse: Rehearse | None = None
    outside: bool = False
    others: Mapping[FileKind, CheckOther] = field(default_factory=dict)
    other_findings: tuple[Finding, ...] = ()

    @property
    def key(self) -> tuple[Any, ...]:
        """Return all on which the check of a file depends that is not run."""
        kinds = sorted(self.others)
        named = self.robot, self.pipe, self.usual_robot, sorted(self.settings.items())
        return *named, self.keep_going, self.outside, kinds


def run_options(wishes: Wishes, settings: Mapping[str, str]) -> str:
    """Return the command line options for running a mission as it was checked."""
    named = (("--robot", wishes.robot), ("--pipe", wishes.pipe))
    options = [part for option, value in named if value is not None for part in (option, value)]
    options += [part for name, value in settings.items() for part in ("--set", f"{name}={value}")]
    return shlex.join(options)


@dataclass
class FilePart:
    """What the check of one file adds to a report, as far as it does not depend on other files.

    Attributes:
        files: The files that were checked.
        names: The files that were read, whose comments allow findings.
        used: The files that a mission or a campaign was checked with.
        called: The files that a mission calls; None: they are not known.
        taken: The settings that a mission has parameters for.
        unset: What is wrong with parameters without a value, unless a mission is called.
        pipe: A pipe that can be built; empty if it is none.
        rehearsals: The runs of a mission.
    """

    findings: list[Finding] = field(default_factory=list)
    files: list[CheckedFile] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    used: list[str] = field(default_factory=list)
    called: list[str] | None = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    unset: list[Finding] = field(default_factory=list)
    pipe: str = ""
    rehearsals: list[Rehearsal] = field(default_factory=list)

    def written(self) -> dict[str, Any]:
        """Return it as JSON; one with runs is not kept."""
        own = {"findings": [*map(written, self.findings)], "unset": [*map(written, self.unset)]}
        return {**vars(self), **own, "files": [[it.name, it.kind] for it in self.files]}

    @classmethod
    def read(cls, data: Mapping[str, Any]) -> FilePart:
        """Return what was written."""
        own = {"findings": [*map(read, data["findings"])], "unset": [*map(read, data["unset"])]}
        files = [CheckedFile(name, FileKind(kind)) for name, kind in data["files"]]
        return cls(**{**data, **own, "files": files})
