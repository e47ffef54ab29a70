"""Options of a check: other robots or pipes, parameters, rehearsals, counterexamples."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.rehearsal import Rehearse
from pirate_sm.core.documents import Document, FileKind

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


Progress = Callable[[int, int, str], None]
"""Called before each file with the number done, the total, and the name of the file."""


def run_options(wishes: Wishes, settings: Mapping[str, str]) -> str:
    """Return the command line options for running a mission as it was checked."""
    named = (("--robot", wishes.robot), ("--pipe", wishes.pipe))
    options = [part for option, value in named if value is not None for part in (option, value)]
    options += [part for name, value in settings.items() for part in ("--set", f"{name}={value}")]
    return shlex.join(options)
