"""Refuse to run a mission with errors."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from typing import ClassVar, Final

from pirate_sm.checking.findings import Finding, Severity, read, settle, written
from pirate_sm.checking.kept_results import kept
from pirate_sm.checking.permissions import SIMULATED
from pirate_sm.core.documents import FileKind
from pirate_sm.core.errors import ExitCode, Hint, PirateError
from pirate_sm.core.loading import LoadedMission, references


class CheckError(PirateError):
    """Raised for missions that are refused before anything moves; holds their findings."""

    exit_code: ClassVar[int] = ExitCode.USAGE

    def __init__(self, names: Sequence[str], findings: tuple[Finding, ...]) -> None:
        from pirate_sm.checking.reports.check_report import CheckedFile, CheckReport
        from pirate_sm.checking.reports.text import text_report

        self.names, self.findings = names, findings
        report = CheckReport(findings, tuple(CheckedFile(name, FileKind.MISSION) for name in names))
        said = text_report(report, lambda role, text: text)
        all_the_same = "runs the mission all the same"
        hint = Hint(f"; --no-check {all_the_same}", f"; check=False {all_the_same}")
        super().__init__(f"{said}\nnothing has moved", hint=hint)


_OF_BENDS = frozenset({"word.never"})
"""Codes that hold only for a detector whose words are about the bends of the pipe."""


_CHECKED: Final[deque[tuple[LoadedMission, tuple[Finding, ...]]]] = deque(maxlen=8)
"""The last missions checked, with their findings: a program runs the same few repeatedly."""


def pass_or_raise(
    loaded: LoadedMission, *, words_of_bends: bool = True, backend: str = ""
) -> tuple[Finding, ...]:
    """Return the findings of a mission that do not prevent its run, or raise an error.

    Args:
        loaded: The mission.
        words_of_bends: Whether the run's detector speaks of the bends of the pipe alone.
        backend: The run's backend; nothing is taken from a file for one that may reach a robot.

    Raises:
        CheckError: The mission has errors that its files do not allow.
    """
    found = _found_in(loaded, afresh=backend not in SIMULATED)
    spared = frozenset() if words_of_bends else _OF_BENDS
    faults = tuple(
        each
        for each in found
        if each.severity is Severity.ERROR and not each.allowed and each.code not in spared
    )
    if faults:
        raise CheckError((loaded.documents[0].name,), faults)
    return found


def _found_in(loaded: LoadedMission, *, afresh: bool) -> tuple[Finding, ...]:
    """Return what the check finds in a mission and its comments allow, kept in a file or not."""
    if afresh or not loaded.origin:
        return _checked(loaded)
    inputs = loaded.origin, references.keeps_inside()
    return kept(
        "gate",
        inputs,
        lambda: [*map(written, _checked(loaded))],
        lambda found: tuple(map(read, found)),
    )


def _checked(loaded: LoadedMission) -> tuple[Finding, ...]:
    """Return what the check finds in a mission; one that was just checked is not explored again."""
    for known, found in tuple(_CHECKED):
        if _same(known, loaded):
            return found
    from pirate_sm.checking.mission.check_mission import check_loaded  # takes long to import

    texts = {document.name: document.text for document in loaded.documents}
    found = settle(check_loaded(loaded).findings, texts)
    _CHECKED.append((loaded, found))
    return found


def _same(one: LoadedMission, other: LoadedMission) -> bool:
    """Return whether two missions are equal, their robots too, which are compared by value."""
    robots = ([getattr(it.robot, each.name) for each in fields(it.robot)] for it in (one, other))
    return replace(one, robot=other.robot) == other and next(robots) == next(robots)


def all_pass_or_raise(missions: Iterable[LoadedMission]) -> None:
    """Raise one error with the findings of all missions that have errors.

    Raises:
        CheckError: There are such missions.
    """
    errors = []
    for loaded in missions:
        try:
            pass_or_raise(loaded, backend="sim")
        except CheckError as error:
            errors.append(error)
    if errors:
        names = dict.fromkeys(name for error in errors for name in error.names)
        findings = dict.fromkeys(each for error in errors for each in error.findings)
        raise CheckError(tuple(names), tuple(findings))
