"""Check one file of a project, by its kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.checking.file_part import FilePart, Wishes, run_options
from pirate_sm.checking.findings import (
    Finding,
    Severity,
    finding_of,
)
from pirate_sm.checking.mission.check_mission import MissionCheck, check_mission
from pirate_sm.checking.mission.mission_parameters import check_settings
from pirate_sm.checking.pipe.check_in_pipe import check_alone
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.project_files import CheckTarget, robots_around
from pirate_sm.checking.reports.check_report import (
    CheckedFile,
    rehearsed,
)
from pirate_sm.checking.robot.check_robot import check_robot
from pirate_sm.core import library
from pirate_sm.core.documents import (
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
    simulated_profile,
    validate,
)
from pirate_sm.core.models import Twin
from pirate_sm.core.on_disk import asks_elsewhere, is_file, resolved

if TYPE_CHECKING:
    from pirate_sm.checking.reports.counterexamples import Examples


class FileCheck:
    """The check of one file."""

    def __init__(self, wishes: Wishes, examples: Examples | None = None) -> None:
        self._wishes, self._examples = wishes, examples
        self._part = FilePart()

    def part(self, target: CheckTarget) -> FilePart:
        """Return what the check of a file adds to a report.

        Raises:
            UsageError: An option does not fit.
        """
        name = shown(target.path)
        if target.kind not in {FileKind.OTHER, FileKind.UNREADABLE}:
            self._part.files.append(CheckedFile(name, target.kind))
        try:
            CHECKS[target.kind](self, target)
        except LoadError as error:
            self._part.findings += map(finding_of, error.problems)
        except UsageError:
            raise
        except Exception as error:
            if not self._wishes.keep_going:
                raise
            asks_elsewhere()  # it may be due to anything
            message = f"the check has failed on this file: {type(error).__name__}: {error}"
            self._add("check.failed", name, message)
        return self._part

    def robot(self, target: CheckTarget) -> None:
        """Check a robot: its profile and its chart."""
        if target.path.name != PROFILE_FILE:
            message = f"the profile of a robot is named {PROFILE_FILE} and has a folder of its own"
            self._add("check.kind", shown(target.path), message)
            return
        checked = check_robot(folder_of(target.path))
        self._keep(checked.documents)
        charts = (CheckedFile(each.name, FileKind.CHART) for each in checked.documents[1:])
        self._part.files += charts
        self._part.findings += checked.findings

    def chart(self, target: CheckTarget) -> None:
        """Check the form of a chart that no robot here uses."""
        document = self._document(target)
        problems = Problems(document)
        outline_chart(document, problems)
        self._part.findings += map(finding_of, problems.all)

    def pipe(self, target: CheckTarget) -> None:
        """Check that a pipe can be built; whether a robot fits follows once its missions are known.

        A mission is checked with its own robot. A pipe without one is checked with the usual one.
        """
        pipe, document = load_pipe(target.path)
        self._keep([document])
        problems = Problems(document)
        check_pipe(pipe, document, problems)
        self._part.findings += map(finding_of, problems.all)
        if not problems.errors:
            self._part.pipe = str(target.path)

    def reached(self, path: Path, known: set[Path]) -> Iterator[Finding]:
        """Yield why the usual robot cannot clamp in a pipe that can be built, or begin in it.

        A pipe is for another robot if its project has robots, and the usual one is not one of them.

        Args:
            path: The file of the pipe.
            known: The folders of the robots that are checked with it.
        """
        own, usual = known | robots_around(path), self._usual(path)
        if own and usual not in own and not (self._wishes.robot or self._wishes.usual_robot):
            return
        with suppress(LoadError):  # reported for the robot or the pipe
            robot = load_robot(usual)
            pipe, document = load_pipe(path)
            problems = Problems(document)
            check_reach(pipe, robot.profile, document, problems)
            if not problems.errors:
                check_alone(Fit(robot.profile, robot.normal, pipe), problems)
            yield from map(finding_of, problems.all)

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
        self._part.used += [each.name for each in checked.documents]
        self._part.findings += checked.findings
        self._remember(checked, shown(target.path), settings)
        if self._examples:
            self._examples.remember(checked, target.path, run_options(self._wishes, settings))
        if self._wishes.rehearse is not None:
            rehearsal, found = rehearsed(checked, target.path, self._wishes.rehearse)
            self._part.rehearsals.append(rehearsal)
            self._part.findings += found

    def _remember(self, checked: MissionCheck, name: str, settings: Mapping[str, str]) -> None:
        """Record parameters without a value, and the missions that this one calls."""
        if checked.loaded is None:
            self._part.called = None
            return
        own = checked.loaded.documents[0]
        self._part.unset += check_settings(checked.loaded.mission, own, settings)
        self._part.called = [each.name for each in checked.documents if each.name != name]

    def calibration(self, target: CheckTarget) -> None:
        """Check a calibration against its robot, if that is known."""
        from pirate_sm.robot.calibration_files import Calibration, load_calibration

        document = self._document(target)
        calibration = validate(document, Calibration)
        folder = folder_of(target.path)
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
        self._part.findings += map(finding_of, problems.all)

    def panel(self, target: CheckTarget) -> None:
        """Check a control panel, and its names against its robot, if that is known."""
        from pirate_sm.robot.control_panel.panel_file import check_names, read_panel, robot_of

        panel, document, problems = read_panel(target.path)
        self._keep([document])
        robot = robot_of(panel, target.path.parent, problems, instead=self._wishes.robot)
        if robot is not None:
            check_names(panel, robot, problems)
        self._part.findings += map(finding_of, problems.all)

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
        self._part.used += [each.name for each in documents]
        self._part.findings += findings

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
        beside = folder_of(path)
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
        self._part.taken += taken
        return taken

    def _document(self, target: CheckTarget) -> Document:
        document = read_document(target.path)
        self._keep([document])
        return document

    def _keep(self, documents: Iterable[Document]) -> None:
        self._part.names += [document.name for document in documents]

    def _add(self, code: str, name: str, message: str) -> None:
        self._part.findings.append(Finding(code, Severity.ERROR, Place(name), message))


CHECKS: Mapping[FileKind, Callable[[FileCheck, CheckTarget], None]] = {
    FileKind.ROBOT: FileCheck.robot,
    FileKind.CHART: FileCheck.chart,
    FileKind.PIPE: FileCheck.pipe,
    FileKind.MISSION: FileCheck.mission,
    FileKind.CALIBRATION: FileCheck.calibration,
    FileKind.CAMERA: FileCheck.camera,
    FileKind.PANEL: FileCheck.panel,
    FileKind.SCRIPT: FileCheck.script,
    FileKind.EXPERIMENT: FileCheck.above,
    FileKind.TWIN: FileCheck.twin,
    FileKind.CAMPAIGN: FileCheck.above,
    FileKind.SCENE: FileCheck.above,
    FileKind.UNREADABLE: FileCheck.other,
    FileKind.OTHER: FileCheck.other,
}


def folder_of(path: Path) -> Path:
    """Return the folder of a file in the library's form, so that a robot is loaded only once."""
    return resolved(path).parent
