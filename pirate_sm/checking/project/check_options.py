"""What a check is asked for: parts in place of the missions' own, rehearsals, counterexamples."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pirate_sm.checking.mission.rehearsal import Rehearse


@dataclass(frozen=True)
class Wishes:
    """What missions are checked with in place of what they say themselves.

    Attributes:
        robot: Name or path of a robot.
        pipe: Name or path of a pipe.
        settings: Values of parameters, for every mission that has them.
        keep_going: Whether a fault of this program becomes a finding.
        counterexamples: The folder that counterexamples are written to; None: they are not.
        rehearse: Runs a mission in the simulator; None: none is run.
        outside: Whether references may leave the project.
    """

    robot: str | None = None
    pipe: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    keep_going: bool = True
    counterexamples: Path | None = None
    rehearse: Rehearse | None = None
    outside: bool = False


Progress = Callable[[int, int, str], None]
"""Called before each file: how many are done, how many there are, and the next one's name."""


def run_options(wishes: Wishes, settings: Mapping[str, str]) -> str:
    """Return the options of a run that is as a mission was checked."""
    named = (("--robot", wishes.robot), ("--pipe", wishes.pipe))
    options = [part for option, value in named if value is not None for part in (option, value)]
    options += [part for name, value in settings.items() for part in ("--set", f"{name}={value}")]
    return shlex.join(options)
