"""`pirate check` and `pirate explain`: what is wrong with files, and what that means."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Severity
from pirate_sm.checking.project import Report, Wishes, check_paths
from pirate_sm.checking.rehearsal import Rehearse
from pirate_sm.checking.reports.text import explained, listed, text_report
from pirate_sm.errors import UsageError
from pirate_sm.model.fault_codes import BUILT_IN_FAULTS
from pirate_sm.spelling import nearest
from pirate_sm.visible import visible

CLEAN, FOUND, NOTHING = 0, 1, 2

_SGR = {
    "error": "1;31", "warning": "1;33", "possible": "1;36", "mark": "1;31", "place": "1",
    "label": "2",
}  # fmt: skip
"""How roles look on a terminal."""

_USUAL_COLUMNS = 80
_ERASE = "\r\x1b[2K"


@dataclass(frozen=True)
class CheckWishes:
    """What the command line asks for, as text."""

    paths: Sequence[str]
    format: str = "text"
    fail_on: str = "error"
    robot: str | None = None
    pipe: str | None = None
    settings: Sequence[str] = ()
    counterexamples: str | None = None
    rehearse: bool = False
    seeds: int = 1
    outside: bool = False
    debug: bool = False


def run_check(wishes: CheckWishes) -> int:
    """The report stands on standard output; the exit code says whether anything was found.

    Raises:
        UsageError: A path leads nowhere, an option does not fit, or the simulator is wanted and
            not installed.
    """
    fail_on = Severity[wishes.fail_on.upper()]
    asked = Wishes(
        robot=wishes.robot,
        pipe=wishes.pipe,
        settings=_settings(wishes),
        keep_going=not wishes.debug,
        counterexamples=None if wishes.counterexamples is None else Path(wishes.counterexamples),
        rehearse=_rehearse(wishes),
        outside=wishes.outside,
    )
    progress = _Progress() if _is_terminal(sys.stderr) else None
    try:
        report = check_paths(wishes.paths, asked, progress)
    finally:
        if progress is not None:
            progress.end()
    _say(_FORMATS[wishes.format](report, fail_on))
    if report.nothing:
        return NOTHING
    return FOUND if report.fails(fail_on) else CLEAN


def run_explain(code: str | None) -> int:
    """Write what is known of a code to standard output; without one the titles of all codes.

    Raises:
        UsageError: There is no such code.
    """
    if code is None:
        _say(listed())
        return 0
    known = {**catalogue.entries(), **BUILT_IN_FAULTS}
    if code not in known:
        close = nearest(code, known)
        hint = f"did you mean '{close}'?" if close else "`pirate explain` lists them all"
        raise UsageError(f"there is no code '{code[:100]}': {hint}")
    _say(explained(code))
    return 0


def _rehearse(wishes: CheckWishes) -> Rehearse | None:
    if not wishes.rehearse:
        if wishes.seeds != 1:
            raise UsageError("--seeds is for --rehearse")
        return None
    from pirate_sm.cli.rehearsing import rehearsing

    return rehearsing(wishes.seeds)


def _settings(wishes: CheckWishes) -> dict[str, str]:
    if not wishes.settings:
        return {}  # without them nothing of a run is needed
    from pirate_sm.cli.run import read_pairs

    return read_pairs("--set", wishes.settings, "NAME=VALUE")


def _text(report: Report, _: Severity) -> str:
    coloured = _is_terminal(sys.stdout) and not os.environ.get("NO_COLOR")
    return text_report(report, _painted if coloured else _plain)


def _json(report: Report, _: Severity) -> str:
    from pirate_sm.checking.reports.json import json_report

    return json_report(report)


def _sarif(report: Report, _: Severity) -> str:
    from pirate_sm.checking.reports.sarif import sarif_report

    return sarif_report(report)


def _junit(report: Report, fail_on: Severity) -> str:
    from pirate_sm.checking.reports.junit import junit_report

    return junit_report(report, fail_on)


def _github(report: Report, _: Severity) -> str:
    from pirate_sm.checking.reports.github import github_report

    return visible(github_report(report), lines=True)


_FORMATS: dict[str, Callable[[Report, Severity], str]] = {
    "text": _text, "json": _json, "sarif": _sarif, "junit": _junit, "github": _github,
}  # fmt: skip


def _plain(_: str, text: str) -> str:
    return visible(text)


def _painted(role: str, text: str) -> str:
    code = _SGR.get(role)
    return f"\x1b[{code}m{visible(text)}\x1b[0m" if code else visible(text)


def _say(text: str) -> None:
    """The text stands on standard output, what its encoding does not have written out."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    print(text.encode(encoding, "backslashreplace").decode(encoding))


def _is_terminal(stream: object) -> bool:
    isatty = getattr(stream, "isatty", None)
    return bool(isatty and isatty()) and os.environ.get("TERM", "dumb") != "dumb"


class _Progress:
    """A line on standard error that says which file is being looked at."""

    def __call__(self, done: int, total: int, name: str) -> None:
        """The line says how far the check is."""
        line = visible(f"checking {done + 1}/{total} {name}")[: _columns() - 1]
        print(f"{_ERASE}{line}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """The line is gone."""
        print(_ERASE, end="", file=sys.stderr, flush=True)


def _columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or _USUAL_COLUMNS
    except (OSError, ValueError):
        return _USUAL_COLUMNS
