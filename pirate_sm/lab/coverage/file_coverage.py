"""The coverage of files: the branches at their lines, and how often what kind of run took each.

A branch belongs to the file that it is in, so that a called mission is covered by the runs of
all missions that call it. A file is known by the hash of its text: runs of another text of it do
not count.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pirate_sm.core.branches import MissionBranch, branches
from pirate_sm.core.documents import Document, Place
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import BranchKey
from pirate_sm.lab.coverage.evidence import EVIDENCE, Evidence, Taken, names_of_commands
from pirate_sm.running.recording.format.header import RecordedFile

_KEYS = {"within": "wait", "on_failure": "", "retry": "", "resume": ""}
"""The keys at whose line a branch is shown, each with the key that is its place."""


class TakenBy(NamedTuple):
    """How often a kind of run has taken a branch, in how many runs, and in which one first."""

    times: int
    runs: int
    first: str


@dataclass
class CoveredBranch:
    """A branch of a mission, with what has taken it.

    Attributes:
        line: The line at which it is shown.
        seen: What has taken it.
    """

    it: MissionBranch
    line: int
    seen: dict[Evidence, TakenBy] = field(default_factory=dict)

    def taken(self, least: Evidence) -> bool:
        """Return whether evidence of this kind, or a stronger one, has taken it."""
        return any(each in self.seen for each in EVIDENCE[EVIDENCE.index(least) :])


@dataclass
class FileCoverage:
    """A mission's file with its branches, in the order of its lines."""

    name: str
    text: str = field(repr=False)
    branches: dict[BranchKey, CoveredBranch] = field(default_factory=dict)

    def by_line(self) -> dict[int, list[CoveredBranch]]:
        """Return its branches by the lines at which they are shown, in order."""
        found: dict[int, list[CoveredBranch]] = defaultdict(list)
        for each in sorted(self.branches.values(), key=lambda each: each.line):
            found[each.line].append(each)
        return dict(found)


class BranchShare(NamedTuple):
    """How many branches were taken, of how many."""

    taken: int
    of: int

    @property
    def percent(self) -> float:
        """Return the share; 100 where there is no branch."""
        return 100.0 * self.taken / self.of if self.of else 100.0


@dataclass
class Coverage:
    """The coverage of missions and of the missions that they call.

    Attributes:
        files: The files by the hashes of their texts.
        rules: By robot and rule what has broken the rule, or would have.
        runs: How many runs count, by what they show.
        others: Runs that do not count, each with the reason.
    """

    files: dict[str, FileCoverage] = field(default_factory=dict)
    rules: dict[tuple[str, str], dict[Evidence, TakenBy]] = field(default_factory=dict)
    runs: dict[Evidence, int] = field(default_factory=dict)
    others: list[str] = field(default_factory=list)

    def declare(self, loaded: LoadedMission, files: Iterable[RecordedFile]) -> None:
        """Add the branches of a mission, which count from then on; ``files`` are its texts."""
        named = {each.name: each for each in files if each.role in ("mission", "called")}
        lines = {
            recorded.name: _lines(document)
            for recorded, document in zip(named.values(), _missions(loaded), strict=False)
        }
        for each in named.values():
            self.files.setdefault(each.sha256, FileCoverage(each.name, each.text))
        for key, branch in branches(loaded.program, names_of_commands(loaded)).items():
            place = Place.read(key.place)
            if place.file in named:
                own = _here(key, place)
                line = lines[place.file].get((key.kind, place.line, place.column), place.line)
                known = self.files[named[place.file].sha256].branches
                known.setdefault(own, CoveredBranch(branch, line))
        for rule in loaded.program.rules:
            self.rules.setdefault((loaded.robot.name, rule.name), {})

    def count(
        self, taken: Taken, robot: str, files: Sequence[RecordedFile], by: Evidence, source: str
    ) -> bool:
        """Count what a run has taken, and return whether any of its texts is of these files.

        Args:
            taken: What it has taken.
            robot: Name of its robot.
            files: Its texts.
            by: What it shows.
            source: What people call it.
        """
        if not any(each.sha256 in self.files for each in files):
            return False
        self.runs[by] = self.runs.get(by, 0) + 1
        for key, times in taken.branches.items():
            if (branch := self.branch(key, files)) is not None:
                _add(branch.seen, by, times, source)
        for rule, times in taken.rules.items():
            if (robot, rule) in self.rules:
                _add(self.rules[robot, rule], by, times, source)
        return True

    def branch(self, key: BranchKey, files: Iterable[RecordedFile]) -> CoveredBranch | None:
        """Return a branch of a program that was made from these texts; None if it is unknown."""
        if not key.place:
            return None
        place = Place.read(key.place)
        of = next((each.sha256 for each in files if each.name == place.file), "")
        return self.files[of].branches.get(_here(key, place)) if of in self.files else None

    def share(self, least: Evidence, files: Sequence[FileCoverage] | None = None) -> BranchShare:
        """Return how many branches were taken by this evidence or a stronger one; of all files."""
        chosen = self.files.values() if files is None else files
        every = [branch for file in chosen for branch in file.branches.values()]
        return BranchShare(sum(each.taken(least) for each in every), len(every))

    def missing(self, least: Evidence) -> Iterator[tuple[FileCoverage, CoveredBranch]]:
        """Yield each branch that no such evidence has taken, with its file."""
        for file in self.files.values():
            for found in file.by_line().values():
                yield from ((file, each) for each in found if not each.taken(least))


def _add(seen: dict[Evidence, TakenBy], by: Evidence, times: int, source: str) -> None:
    before = seen.get(by, TakenBy(0, 0, source))
    seen[by] = TakenBy(before.times + times, before.runs + 1, before.first)


def _here(key: BranchKey, place: Place) -> BranchKey:
    """Return the key of a branch within its file."""
    return key._replace(place=f"{place.line}:{place.column}")


def _missions(loaded: LoadedMission) -> tuple[Document, ...]:
    """Return the documents of a mission and of those that it calls."""
    mission, *others, _ = loaded.documents
    return mission, *others[len(loaded.loaded_robot.documents) :]


def _lines(document: Document) -> Mapping[tuple[str, int, int], int]:
    """Return the lines of keys such as ``within``, by the branch's kind and place."""
    found: dict[tuple[str, int, int], int] = {}
    for path, mapping in _mappings(document.data, ()):
        for key, at in _KEYS.items():
            if key in mapping and (not at or at in mapping):
                place = document.place_of((*path, at) if at else path)
                line = document.place_of((*path, key), key=True).line
                found[key, place.line, place.column] = line
    return found


def _mappings(
    data: Any, path: tuple[str | int, ...]
) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    if isinstance(data, dict):
        yield path, data
    items = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data)
        if isinstance(data, list)
        else ()
    )
    for key, value in items:
        yield from _mappings(value, (*path, key))
