"""The counterexamples of a whole check, each under a name of its own in one folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.checking.reports.counterexamples import usual_name, write_counterexample
from pirate_sm.errors import UsageError


class Examples:
    """Keeps what counterexamples are made from until it is clear which findings there are.

    Args:
        folder: Where to write them; made when the first one is written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._checks: dict[int, tuple[MissionCheck, Path, str]] = {}  # by identity of explorations

    def remember(self, check: MissionCheck, path: Path, options: str) -> None:
        """The findings of a mission can have counterexamples.

        Args:
            check: What was found.
            path: The mission's file.
            options: That a run needs to be as the check was.
        """
        for finding in check.findings:
            for found, _ in finding.course:
                self._checks[id(found)] = (check, path, options)

    def write(self, findings: Iterable[Finding]) -> list[Finding]:
        """Every finding that nobody allows and a course of events leads to has its files.

        Raises:
            UsageError: The folder cannot be written.
        """
        try:
            return list(self._written(findings))
        except OSError as error:
            raise UsageError(f"'{self._folder}' cannot be written: {error.strerror}") from None

    def _written(self, findings: Iterable[Finding]) -> Iterator[Finding]:
        taken: set[str] = set()
        for finding in findings:
            known = self._checks.get(id(finding.course[0][0])) if finding.course else None
            if known is None or finding.allowed:
                yield finding
                continue
            check, path, options = known
            name = _free(usual_name(finding), taken)
            yield write_counterexample(finding, check, self._folder, name, path, options)


def _free(name: str, taken: set[str]) -> str:
    """A name that is not taken; now it is."""
    free, number = name, 1
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    taken.add(free)
    return free
