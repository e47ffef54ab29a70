"""Check the files of a project, and report on all of them."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from pirate_sm.checking.findings import Finding, Severity, each_once, finding_of, settle
from pirate_sm.checking.mission.check_mission import MissionCheck, check_mission
from pirate_sm.checking.mission.mission_parameters import check_settings
from pirate_sm.checking.pipe.check_in_pipe import check_alone
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.project_files import CheckTarget, find_targets, robots_around
from pirate_sm.checking.reports.check_report import (
    CheckedFile,
    CheckReport,
    Rehearsal,
    Rehearse,
    rehearsed,
)
from pirate_sm.checking.robot.check_robot import check_robot
from pirate_sm.core import library
from pirate_sm.core.documents import (
    LARGEST_FILE,
    Document,
    FileKind,
    LoadError,
    Place,
    Problems,
    read_document,
)
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE, shown
from pirate_sm.core.loading import (
    check_pipe,
    check_reach,
    load_pipe,
    load_robot,
    outline_chart,
    references,
    simulated_profile,
    validate,
)
from pirate_sm.core.models import Pipe, Twin
from pirate_sm.core.on_disk import is_file

if TYPE_CHECKING:
    from pirate_sm.checking.reports.counterexamples import Examples

# --- options -------------------------------------------------------------------------------------


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
    check = _Check(wishes)
    found = find_targets(paths)
    check.findings += (*wishes.other_findings, *found.findings)
    with references.kept_inside(wanted=not wishes.outside):
        for number, target in enumerate(found.targets):
            if progress is not None:
                progress(number, len(found.targets), shown(target.path))
            check.take(target)
    report = check.report()
    return replace(report, where=found.where, nothing=not found.targets)


class _Check:
    """A running check; collects findings and the files that they concern."""

    def __init__(self, wishes: Wishes) -> None:
        if wishes.robot is not None:
            library.find_robot(wishes.robot, Path.cwd())
        if wishes.pipe is not None:
            library.find_pipe(wishes.pipe, Path.cwd())
        self.findings: list[Finding] = []
        self._wishes = wishes
        self._files: list[CheckedFile] = []
        self._texts: dict[str, str] = {}
        self._set: set[str] = set()  # settings used by some mission
        self._unset: dict[str, tuple[Finding, ...]] = {}  # parameters of missions, by their files
        self._called: set[str] | None = set()  # files that others use; None: not all are known
        self._pipes: dict[str, tuple[CheckTarget, Pipe, Document]] = {}  # by their files
        self._used: set[str] = set()  # files that missions or campaigns were checked with
        self._rehearsals: list[Rehearsal] = []
        folder = wishes.counterexamples
        self._examples = None if folder is None else _examples_in(folder)

    def take(self, target: CheckTarget) -> None:
        """Check one file, and add its findings."""
        name = shown(target.path)
        if target.kind is FileKind.CHART and name in self._texts:
            return  # checked with its robot
        known_here = _CHECKS[target.kind] is not _Check.above
        if not (known_here or target.named or target.kind in self._wishes.others):
            return
        if target.kind not in {FileKind.OTHER, FileKind.UNREADABLE}:
            self._files.append(CheckedFile(name, target.kind))
        try:
            _CHECKS[target.kind](self, target)
        except LoadError as error:
            self.findings += map(finding_of, error.problems)
        except UsageError:
            raise
        except Exception as error:
            if not self._wishes.keep_going:
                raise
            message = f"the check has failed on this file: {type(error).__name__}: {error}"
            self._add("check.failed", name, message)

    def report(self) -> CheckReport:
        """Return the report with distinct findings, in which allowed ones are marked."""
        unused = self._wishes.settings.keys() - self._set
        if unused:
            raise UsageError(f"no mission here has a parameter '{min(unused)}'")
        for name, (target, pipe, document) in self._pipes.items():
            if name not in self._used:
                self.findings += map(finding_of, self._reached(target.path, pipe, document).all)
        if self._called:  # a called mission begins wherever its callers have come to
            self.findings = [
                each
                for each in self.findings
                if each.code != "trigger.at_start" or each.place.file not in self._called
            ]
        for name in {each.place.file for each in self.findings} | {f.name for f in self._files}:
            self._read(name)
        for name, found in self._unset.items():
            if self._called is not None and name not in self._called:
                self.findings += found
        settled = settle(each_once(self.findings), self._texts)
        ordered = sorted(settled, key=lambda each: each.order)
        if self._examples:
            ordered = self._examples.write(ordered)
        return CheckReport(tuple(ordered), tuple(self._files), tuple(self._rehearsals))

    def robot(self, target: CheckTarget) -> None:
        """Check a robot: its profile and its chart."""
        if target.path.name != PROFILE_FILE:
            message = f"the profile of a robot is named {PROFILE_FILE} and has a folder of its own"
            self._add("check.kind", shown(target.path), message)
            return
        checked = check_robot(_folder(target.path))
        self._keep(checked.documents)
        self._files += [CheckedFile(each.name, FileKind.CHART) for each in checked.documents[1:]]
        self.findings += checked.findings

    def chart(self, target: CheckTarget) -> None:
        """Check the form of a chart that no robot here uses."""
        document = self._document(target)
        problems = Problems(document)
        outline_chart(document, problems)
        self.findings += map(finding_of, problems.all)

    def pipe(self, target: CheckTarget) -> None:
        """Check that a pipe can be built; whether a robot fits follows once its missions are known.

        A mission is checked with its own robot. A pipe without one is checked with the usual one.
        """
        pipe, document = load_pipe(target.path)
        self._keep([document])
        problems = Problems(document)
        check_pipe(pipe, document, problems)
        self.findings += map(finding_of, problems.all)
        if not problems.errors:
            self._pipes[document.name] = target, pipe, document

    def _reached(self, path: Path, pipe: Pipe, document: Document) -> Problems:
        """Return why the usual robot cannot clamp in a pipe, or begin in it.

        A pipe is for another robot if its project has robots, and the usual one is not one of them.
        """
        problems = Problems(document)
        known = {_folder(Path(each)) for each in self._texts if Path(each).name == PROFILE_FILE}
        own, usual = known | robots_around(path), self._usual(path)
        if own and usual not in own and not (self._wishes.robot or self._wishes.usual_robot):
            return problems
        with suppress(LoadError):  # reported for the robot
            robot = load_robot(usual)
            check_reach(pipe, robot.profile, document, problems)
            if not problems.errors:
                check_alone(Fit(robot.profile, robot.normal, pipe), problems)
        return problems

    def _usual(self, path: Path) -> Path:
        """Return the folder of the robot of a file that names none."""
        wanted = self._wishes.robot or self._wishes.usual_robot
        return self._robot_of(path, wanted or library.robots()[0].name)

    def mission(self, target: CheckTarget) -> None:
        """Check a mission with its robot, its pipe and the missions that it calls."""
        settings = self._settings(target)
        checked = check_mission(
            target.path, robot=self._wishes.robot, pipe=self._wishes.pipe, settings=settings
        )
        self._keep(checked.documents)
        self._used |= {each.name for each in checked.documents}
        self.findings += checked.findings
        self._remember(checked, shown(target.path), settings)
        if self._examples:
            self._examples.remember(checked, target.path, run_options(self._wishes, settings))
        if self._wishes.rehearse is not None:
            rehearsal, found = rehearsed(checked, target.path, self._wishes.rehearse)
            self._rehearsals.append(rehearsal)
            self.findings += found

    def _remember(self, checked: MissionCheck, name: str, settings: Mapping[str, str]) -> None:
        """Record parameters without a value, and the missions that this one calls."""
        if checked.loaded is None:
            self._called = None
            return
        own = checked.loaded.documents[0]
        self._unset[name] = check_settings(checked.loaded.mission, own, settings)
        if self._called is not None:
            self._called |= {each.name for each in checked.documents} - {name}

    def calibration(self, target: CheckTarget) -> None:
        """Check a calibration against its robot, if that is known."""
        from pirate_sm.robot.calibration_files import Calibration, load_calibration

        document = self._document(target)
        calibration = validate(document, Calibration)
        folder = _folder(target.path)
        if not is_file(folder / PROFILE_FILE):
            try:
                folder = library.find_robot(calibration.robot, Path.cwd())
            except UsageError as error:
                problems = Problems(document)
                problems.add("calibration.robot", ("robot",), str(error))
                problems.raise_errors()
        try:
            robot = load_robot(folder)
        except LoadError:
            return  # reported for the robot
        load_calibration(target.path, robot)

    def camera(self, target: CheckTarget) -> None:
        """Check a camera; what it looks for only if it is evidently for the usual robot.

        A camera names no robot: a robot that it does not fit is an error where it is used.
        """
        from pirate_sm.robot.camera_file import check_robot_seen, load_camera

        camera, document = load_camera(target.path)
        self._keep([document])
        problems = Problems(document)
        with suppress(LoadError):
            usual = load_robot(self._usual(target.path)).profile
            if {link.module for link in usual.body.links} & {*camera.modules}:
                check_robot_seen(camera, usual, problems, Severity.WARNING)
        self.findings += map(finding_of, problems.all)

    def panel(self, target: CheckTarget) -> None:
        """Check a control panel, and its names against its robot, if that is known."""
        from pirate_sm.robot.control_panel.panel_file import check_names, read_panel, robot_of

        panel, document, problems = read_panel(target.path)
        self._keep([document])
        robot = robot_of(panel, target.path.parent, problems, instead=self._wishes.robot)
        if robot is not None:
            check_names(panel, robot, problems)
        self.findings += map(finding_of, problems.all)

    def script(self, target: CheckTarget) -> None:
        """Check the form of a trace script; its names depend on its mission."""
        from pirate_sm.robot.backends.trace_script import read_script

        read_script(self._document(target))

    def above(self, target: CheckTarget) -> None:
        """Check a file of a kind that only a layer above knows."""
        check = self._wishes.others.get(target.kind)
        if check is None:
            message = f"{target.kind}s are checked by the command `pirate check`"
            self._add("check.kind", shown(target.path), message)
            return
        documents, findings = check(target.path)
        self._keep(documents[:1])  # the rest is not checked for itself here
        self._used |= {each.name for each in documents}
        self.findings += findings

    def twin(self, target: CheckTarget) -> None:
        """Check the numbers of a simulated robot against its profile."""
        document = self._document(target)
        twin = validate(document, Twin)
        try:
            robot = load_robot(self._robot_of(target.path, twin.robot))
        except UsageError as error:
            problems = Problems(document)
            problems.add("twin.robot", ("robot",), str(error))
            problems.raise_errors()
        except LoadError:
            return  # reported for the robot
        simulated_profile(robot.profile, str(target.path))

    def _robot_of(self, path: Path, name: str) -> Path:
        """Return the folder of the robot that a file is for: the wanted one, else of its name."""
        if self._wishes.robot is not None:
            return library.find_robot(self._wishes.robot, Path.cwd())
        beside = _folder(path)
        return beside if is_file(beside / PROFILE_FILE) else library.find_robot(name, Path.cwd())

    def other(self, target: CheckTarget) -> None:
        """Report a file of no known kind, if it was named explicitly."""
        if target.kind is FileKind.UNREADABLE or target.path.suffix in library.SUFFIXES:
            self._document(target)
        message = (
            "this is not a robot (`robot` and `boards`), mission (`mission` and `phases`), pipe"
            " (`pipe` and `segments` or `runs`), camera (`camera` and `source`), calibration"
            " (`robot` and `zeros`), panel (`panel` and `buttons`), trace script, experiment"
            " (`experiment`), twin (`robot` and `motors`), campaign (`campaign`) or scene"
            " (`scene` and `steps`)"
        )
        self._add("check.kind", shown(target.path), message)

    def _settings(self, target: CheckTarget) -> dict[str, str]:
        """Return the settings for parameters of this mission."""
        wanted = self._wishes.settings
        if not wanted:
            return {}
        data = read_document(target.path).data
        own = data.get("parameters") if isinstance(data, dict) else None
        taken = {n: v for n, v in wanted.items() if isinstance(own, dict) and n in own}
        self._set |= taken.keys()
        return taken

    def _document(self, target: CheckTarget) -> Document:
        document = read_document(target.path)
        self._keep([document])
        return document

    def _keep(self, documents: Iterable[Document]) -> None:
        for document in documents:
            self._texts[document.name] = document.text

    def _read(self, name: str) -> None:
        """Read the text of an unusable file, for its allowances."""
        if name in self._texts:
            return
        with suppress(OSError, ValueError):
            path = Path(name)
            if is_file(path) and path.stat().st_size <= LARGEST_FILE:
                self._texts[name] = path.read_text("utf-8-sig", errors="replace")

    def _add(self, code: str, name: str, message: str) -> None:
        self.findings.append(Finding(code, Severity.ERROR, Place(name), message))


def _examples_in(folder: Path) -> Examples:
    from pirate_sm.checking.reports.counterexamples import Examples

    return Examples(folder)


_CHECKS: Mapping[FileKind, Callable[[_Check, CheckTarget], None]] = {
    FileKind.ROBOT: _Check.robot,
    FileKind.CHART: _Check.chart,
    FileKind.PIPE: _Check.pipe,
    FileKind.MISSION: _Check.mission,
    FileKind.CALIBRATION: _Check.calibration,
    FileKind.CAMERA: _Check.camera,
    FileKind.PANEL: _Check.panel,
    FileKind.SCRIPT: _Check.script,
    FileKind.EXPERIMENT: _Check.above,
    FileKind.TWIN: _Check.twin,
    FileKind.CAMPAIGN: _Check.above,
    FileKind.SCENE: _Check.above,
    FileKind.UNREADABLE: _Check.other,
    FileKind.OTHER: _Check.other,
}


def _folder(path: Path) -> Path:
    """Return the folder of a file in the library's form, so that a robot is loaded only once."""
    return path.resolve().parent
