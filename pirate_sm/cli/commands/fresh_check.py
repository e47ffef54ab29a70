"""What `pirate check` does where no kept result can be used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Finding, Severity, finding_of
from pirate_sm.checking.permissions import is_below
from pirate_sm.checking.reports.check_report import CheckReport, FileChange, Rehearse, changes_of
from pirate_sm.checking.reports.text import Paint, text_report
from pirate_sm.cli import settings
from pirate_sm.cli.options.checks import CheckOptions
from pirate_sm.cli.options.declaring import read_settings
from pirate_sm.cli.output.terminal import progress, wrapped
from pirate_sm.core.documents import Document, FileKind, Problems
from pirate_sm.core.errors import UsageError
from pirate_sm.core.visible import visible

CLEAN, FOUND, NOTHING = 0, 1, 2
"""Exit codes."""

_MOST_ROUNDS = 10
"""How often files are fixed and checked again, because one fault can hide the next. [decided]"""


def fresh_check(
    options: CheckOptions, columns: int | None, *, coloured: bool
) -> tuple[int, str | None]:
    """Return the exit code, which says whether anything was found, and the report or changes.

    Args:
        options: The options.
        columns: How wide lines of text are; None: as wide as they come.
        coloured: Whether text is coloured.

    Raises:
        UsageError: A path does not exist, an option does not fit, or the simulator is needed and
            not installed.
    """
    fail_on = Severity[options.fail_on.upper()]
    asked = wishes_of(options)
    if options.unsafe_fixes and not (options.fix or options.diff):
        raise UsageError("--unsafe-fixes is for --fix and --diff")
    changing, fixed = options.fix or options.diff, 0
    quick = replace(asked, rehearse=None, counterexamples=None) if changing else asked
    report = _report(options, quick)
    for _ in range(_MOST_ROUNDS if changing else 0):
        changes = changes_of(report, options.paths or (), unsafe=options.unsafe_fixes)
        if options.diff or not changes:
            break
        for change in changes:
            change.write()
        fixed += sum(change.fixed for change in changes)
        report = _report(options, quick)
    if options.diff and not report.nothing:
        if changes:
            return FOUND, visible("\n".join(map(FileChange.diff, changes)), lines=True)
        return CLEAN, None
    if quick != asked:
        report = _report(options, asked)
    left = changes_of(report, options.paths or (), unsafe=True)
    safe = sum(change.safe for change in left)
    fixable = safe, sum(change.fixed for change in left) - safe
    report = replace(report, fixed=fixed, fixable=fixable)
    text = _written(report, options.format, fail_on, _painted if coloured else _plain, columns)
    if report.nothing:
        return NOTHING, text
    return FOUND if report.fails(fail_on) else CLEAN, text


def wishes_of(options: CheckOptions) -> Wishes:
    """Return what a check is asked for by its options and by the settings.

    Raises:
        UsageError: An option does not fit, or the simulator is needed and not installed.
    """
    return Wishes(
        robot=options.robot,
        pipe=options.pipe,
        usual_robot=settings.values()["robot"].value or None,
        settings=read_settings(options.settings),
        keep_going=not options.debug,
        counterexamples=None if options.counterexamples is None else Path(options.counterexamples),
        rehearse=_rehearse(options),
        outside=options.outside,
        others={
            FileKind.EXPERIMENT: _check_experiment,
            FileKind.CAMPAIGN: _check_campaign,
            FileKind.SCENE: _check_scene,
        },
        other_findings=tuple(_refused_settings(options.paths)),
    )


def _report(options: CheckOptions, asked: Wishes) -> CheckReport:
    with progress("checking") as watch:

        def show(done: int, total: int, name: str) -> None:
            watch(done / total, f", {visible(name)}")

        return check_paths(options.paths or (), asked, show)


def _refused_settings(paths: Sequence[str] | None) -> Iterator[Finding]:
    """Yield warnings of the project's settings that runs will refuse, if its file is checked."""
    file, found = settings.project_file(), settings.values()
    if file is None or (paths and not any(is_below(file, Path(each)) for each in paths)):
        return
    for problem in settings.refused(list(found), found):
        yield replace(finding_of(problem), code="check.untrusted", severity=Severity.WARNING)


def _form(document: Document, problems: Problems) -> tuple[list[Document], Iterable[Finding]]:
    return [document], map(finding_of, problems.all)


def _check_experiment(path: Path) -> tuple[list[Document], Iterable[Finding]]:
    from pirate_sm.lab.experiments.experiment_files import check_experiment

    return _form(*check_experiment(path))


def _check_scene(path: Path) -> tuple[list[Document], Iterable[Finding]]:
    from pirate_sm.cli.scene_steps import why_unplayable  # needs the parsers of all commands
    from pirate_sm.lab.gallery.scene_file import HERE, OUT, check_scene

    folders = {OUT: path.parent / OUT, HERE: path.parent}
    return _form(*check_scene(path, lambda step: why_unplayable(step, folders)))


def _check_campaign(path: Path) -> tuple[list[Document], list[Finding]]:
    from pirate_sm.lab.campaign.campaign_file import check_campaign  # needs the simulator

    return check_campaign(path)


def _rehearse(options: CheckOptions) -> Rehearse | None:
    if not options.rehearse:
        if options.seeds != 1:
            raise UsageError("--seeds is for --rehearse")
        return None
    from pirate_sm.cli.commands.rehearsal import rehearsing  # needs the simulator

    return rehearsing(options.seeds)


def _written(
    report: CheckReport, wanted: str, fail_on: Severity, paint: Paint, columns: int | None
) -> str:
    """Return the report in the format that is wanted."""
    if wanted == "text":
        if columns is None:
            return text_report(report, paint)
        text = text_report(report, paint, columns)
        return "\n".join(wrapped(line, columns) for line in text.split("\n"))
    from pirate_sm.checking.reports import junit, machine_readable

    match wanted:
        case "json":
            return machine_readable.json_report(report)
        case "sarif":
            return machine_readable.sarif_report(report)
        case "junit":
            return junit.junit_report(report, fail_on)
        case _:
            return visible(machine_readable.github_report(report), lines=True)


def _plain(_: str, text: str) -> str:
    return visible(text)


def _painted(role: str, text: str) -> str:
    from rich.color import ColorSystem
    from rich.style import Style

    style = Style.parse(_styles().get(role, ""))
    return style.render(visible(text), color_system=ColorSystem.STANDARD)


@cache
def _styles() -> Mapping[str, str]:
    """Return the looks of the roles of text on a terminal."""
    from pirate_sm.views.showing.roles import ACCENT, BAD, MUTED, ON_A_TERMINAL, STRONG, WARN

    return {
        "error": f"bold {ON_A_TERMINAL[BAD]}",
        "warning": f"bold {ON_A_TERMINAL[WARN]}",
        "possible": f"bold {ON_A_TERMINAL[ACCENT]}",
        "mark": f"bold {ON_A_TERMINAL[BAD]}",
        "place": ON_A_TERMINAL[STRONG],
        "label": ON_A_TERMINAL[MUTED],
    }
