"""Results of running missions in the simulator, and findings from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from pirate_sm.checking.allowances import settle
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.checking.mission.mission_view import MissionPlaces
from pirate_sm.core.files import shown
from pirate_sm.core.loading import LoadedMission


@dataclass(frozen=True)
class RehearsedRun:
    """The result of one run.

    Attributes:
        outcome: The engine's outcome: ``succeeded``, ``failed``, ``fault`` or ``interrupted``.
        message: The reason.
        time_s: Its duration in mission time.
    """

    seed: int
    outcome: str
    message: str
    time_s: float

    @property
    def succeeded(self) -> bool:
        """Return whether the mission succeeded."""
        return self.outcome == "succeeded"


@dataclass(frozen=True)
class Nearly:
    """A near miss in a run.

    Attributes:
        text: A description with numbers.
        share: How close it was; it happens at 1.
        at_s: Mission time.
    """

    text: str
    share: float
    at_s: float
    seed: int


@dataclass(frozen=True)
class Rehearsal:
    """The runs of one mission.

    Attributes:
        file: Its file, as in messages.
        nearly: The near misses of all runs, the closest first.
        skipped: Why there are no runs; empty if there are.
        at_once: Places of triggers whose condition was true at the start of their wait, with text.
    """

    file: str
    runs: tuple[RehearsedRun, ...] = ()
    nearly: tuple[Nearly, ...] = ()
    skipped: str = ""
    at_once: tuple[tuple[str, str], ...] = ()


Rehearse: TypeAlias = Callable[[LoadedMission, Path], Rehearsal]
"""Runs the mission that was read from this file."""


def rehearsed(
    check: MissionCheck, path: Path, rehearse: Rehearse
) -> tuple[Rehearsal, tuple[Finding, ...]]:
    """Run a mission without errors in the simulator, and return the results and findings.

    Args:
        check: The result of the mission's check.
        path: Its file.
        rehearse: Runs it.
    """
    texts = {document.name: document.text for document in check.documents}
    settled = settle(check.findings, texts)
    wrong = any(each.severity is Severity.ERROR and not each.allowed for each in settled)
    if check.loaded is None or wrong:
        return Rehearsal(shown(path), skipped="the check has found errors in it"), ()
    done = rehearse(check.loaded, path)
    places = MissionPlaces(check.loaded)
    found = [
        places.finding(
            places.read(place),
            "rehearsal.at_once",
            f"in the simulator '{text}' was true already as its wait began",
        )
        for place, text in done.at_once
    ]
    failed = [run for run in done.runs if not run.succeeded]
    if not failed:
        return done, tuple(found)
    first = failed[0]
    message = f"in the simulator it does not succeed: {first.message} (after {first.time_s:.1f} s)"
    if len(done.runs) > 1:
        seeds = ", ".join(str(run.seed) for run in failed)
        message += f"; {len(failed)} of {len(done.runs)} runs, with the seeds {seeds}"
    found.append(places.finding(places.mission(), "rehearsal.failed", message))
    return done, tuple(found)
