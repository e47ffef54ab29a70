"""Check the files of a project, and report on all of them."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pirate_sm.checking.check_file import CHECKS, FileCheck, folder_of
from pirate_sm.checking.file_part import FilePart, Wishes
from pirate_sm.checking.findings import (
    Finding,
    each_once,
    settle,
)
from pirate_sm.checking.kept_results import again, kept
from pirate_sm.checking.project_files import CheckTarget, find_targets
from pirate_sm.checking.reports.check_report import (
    CheckReport,
)
from pirate_sm.core import library
from pirate_sm.core.documents import (
    LARGEST_FILE,
    FileKind,
)
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE, shown
from pirate_sm.core.loading import (
    references,
)
from pirate_sm.core.on_disk import opened

if TYPE_CHECKING:
    from pirate_sm.checking.reports.counterexamples import Examples

Progress = Callable[[int, int, str], None]
"""Called before each file with the number done, the total, and the name of the file."""


_LONG = (FileKind.MISSION, FileKind.CAMPAIGN)
"""The kinds of files of which missions are explored."""

FEWEST: Final = 6
"""How many of them are worth processes. [decided]"""


# --- the check -----------------------------------------------------------------------------------


def check_paths(
    paths: Iterable[str] = (), wishes: Wishes | None = None, progress: Progress | None = None
) -> CheckReport:
    """Return a report on files and on all files in folders.

    Args:
        paths: Files, folders or names of shipped files; empty for the working directory.
        wishes: The options of the check.
        progress: Called before each file.

    Raises:
        UsageError: A path does not exist, or an option does not fit.
    """
    wishes = wishes or Wishes()
    for find, name in ((library.find_robot, wishes.robot), (library.find_pipe, wishes.pipe)):
        if name is not None:
            find(name, Path.cwd())
    found = find_targets(paths)
    project = _Project(wishes, [*wishes.other_findings, *found.findings])
    with (
        references.kept_inside(wanted=not wishes.outside),
        _uncollected(),
        project.shared_out(found.targets),
    ):
        for number, target in enumerate(found.targets):
            if progress is not None:
                progress(number, len(found.targets), shown(target.path))
            project.take(target)
        report = project.report()
    return replace(report, where=found.where, nothing=not found.targets)


@contextmanager
def _uncollected() -> Iterator[None]:
    """Do not look for cycles: explorations are many objects that live on, and hold few of them."""
    wanted = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if wanted:
            gc.enable()


class _Project:
    """A running check; collects what the checks of its files add."""

    def __init__(self, wishes: Wishes, findings: list[Finding]) -> None:
        self._wishes, self._findings = wishes, findings
        self._parts: dict[str, FilePart] = {}  # by the names of their files
        self._names: dict[str, None] = {}
        folder = wishes.counterexamples
        self._examples = None if folder is None else _examples_in(folder)
        self._known: dict[CheckTarget, FilePart] = {}  # from results that were kept
        self._make: Callable[[CheckTarget], dict[str, Any]] = self._checked

    @contextmanager
    def shared_out(self, targets: Sequence[CheckTarget]) -> Iterator[None]:
        """Return a context in which processes check what takes long and is not kept."""
        if self._examples or self._wishes.rehearse or not self._wishes.keep_going:
            yield
            return
        fresh = []
        for target in (each for each in targets if each.kind in _LONG):
            part = again("file", self._key(target), FilePart.read)
            if part is None:
                fresh.append(target)
            else:
                self._known[target] = part
        if len(fresh) < FEWEST:
            yield
            return
        from pirate_sm.checking.shared_out import shared_out

        with shared_out(fresh, self._checked) as self._make:
            yield

    def take(self, target: CheckTarget) -> None:
        """Check one file."""
        name, wishes = shown(target.path), self._wishes
        if target.kind is FileKind.CHART and name in self._names:
            return  # checked with its robot
        known_here = CHECKS[target.kind] is not FileCheck.above
        if not (known_here or target.named or target.kind in wishes.others):
            return
        if self._examples or wishes.rehearse:
            part = FileCheck(wishes, self._examples).part(target)
        else:
            part = self._known.get(target) or kept(
                "file", self._key(target), lambda: self._make(target), FilePart.read
            )
        self._parts[name] = part
        self._names |= dict.fromkeys(part.names)

    def _checked(self, target: CheckTarget) -> dict[str, Any]:
        return FileCheck(self._wishes).part(target).written()

    def _key(self, target: CheckTarget) -> tuple[Any, ...]:
        return str(target.path), str(target.kind), target.named, *self._wishes.key

    def report(self) -> CheckReport:
        """Return the report with distinct findings, in which allowed ones are marked."""
        parts = self._parts.values()
        unused = self._wishes.settings.keys() - {name for part in parts for name in part.taken}
        if unused:
            raise UsageError(f"no mission here has a parameter '{min(unused)}'")
        findings = [*self._findings, *(each for part in parts for each in part.findings)]
        robots = {folder_of(Path(each)) for each in self._names if Path(each).name == PROFILE_FILE}
        used = {name for part in parts for name in part.used}
        for name, part in self._parts.items():
            if part.pipe and name not in used:
                findings += FileCheck(self._wishes).reached(Path(part.pipe), robots)
        listed = [part.called for part in parts if part.called is not None]
        called = {name for names in listed for name in names} if len(listed) == len(parts) else None
        if called:  # a called mission begins where its callers are
            findings = [
                each
                for each in findings
                if each.code != "trigger.at_start" or each.place.file not in called
            ]
        for name, part in self._parts.items():
            if called is not None and name not in called:
                findings += part.unset
        files = tuple(file for part in parts for file in part.files)
        names = dict.fromkeys([*self._names, *(each.place.file for each in findings)])
        texts = {name: _text_of(name) for name in names | dict.fromkeys(it.name for it in files)}
        settled = settle(each_once(findings), {n: t for n, t in texts.items() if t is not None})
        ordered = sorted(settled, key=lambda each: each.order)
        if self._examples:
            ordered = self._examples.write(ordered)
        rehearsals = tuple(each for part in parts for each in part.rehearsals)
        return CheckReport(tuple(ordered), files, rehearsals)


def _text_of(name: str) -> str | None:
    """Return the text of a file, for its allowances; None if it has none."""
    try:
        with opened(name) as stream:
            content = stream.read(LARGEST_FILE + 1)
    except (OSError, ValueError):
        return None
    text = content.decode("utf-8-sig", errors="replace")
    return text if len(content) <= LARGEST_FILE else None


def _examples_in(folder: Path) -> Examples:
    from pirate_sm.checking.reports.counterexamples import Examples

    return Examples(folder)
