"""Recorded runs as lines of a list: set-up, outcome, faults."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

from pirate_sm.core import effects as fx
from pirate_sm.core.simulation import SIMULATORS
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import Recording

Outcome: TypeAlias = Literal[
    "succeeded", "failed", "interrupted", "fault", "unfinished", "unreadable"
]


@dataclass(frozen=True)
class ListedRun:
    """A line of the list.

    Attributes:
        name: Name of its file.
        outcome: How it ended; ``unfinished`` if the recording does not contain the end,
            ``unreadable`` if it cannot be read.
        message: The reason for the outcome, in a sentence.
        link: Link to its report, relative to the list; empty without one.
        began: ISO 8601 with the zone.
        seed: Seed of the simulator; None without random numbers.
        conditions: A coarser fidelity, defects and parameters that the user set, in words.
        faults: Number of reports of each fault, by code.
    """

    name: str
    outcome: Outcome
    message: str = ""
    link: str = ""
    mission: str = ""
    robot: str = ""
    backend: str = ""
    began: str = ""
    seed: int | None = None
    conditions: tuple[str, ...] = ()
    duration_s: float = 0.0
    faults: Mapping[str, int] = field(default_factory=dict)


def listed(recording: Recording, link: str) -> ListedRun:
    """Return the line of a run.

    Args:
        recording: The run; it is read, but not replayed.
        link: Link to its report.

    Raises:
        RecordingError: The recording is damaged.
    """
    faults: Counter[str] = Counter()
    ended: fx.Ended | None = None
    for step in recording.steps():
        for effect in step.effects:
            if isinstance(effect, fx.Fault):
                faults[effect.code] += 1
            elif isinstance(effect, fx.Ended):
                ended = effect
    header = recording.header
    return ListedRun(
        name=recording.path.name,
        outcome=ended.outcome if ended else "unfinished",
        message=ended.message if ended else "The recording breaks off.",
        link=link,
        mission=header.mission,
        robot=header.robot,
        backend=header.backend,
        began=header.began,
        seed=header.options.get("seed", 0) if header.backend in SIMULATORS else None,
        conditions=_conditions(header),
        duration_s=recording.until_s,
        faults=dict(faults),
    )


def unreadable(path: Path, why: str) -> ListedRun:
    """Return the line of a recording that cannot be read."""
    return ListedRun(name=path.name, outcome="unreadable", message=why)


def _conditions(header: RunHeader) -> tuple[str, ...]:
    settings = header.options.get("settings") or {}
    parameters = (f"{name} = {value}" for name, value in settings.items())
    return (*header.coarser, *header.options.get("defects", ()), *parameters)
