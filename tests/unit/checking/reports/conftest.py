"""Reports with everything in them that a format must be able to hold."""

from __future__ import annotations

import pytest

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckedFile, CheckReport
from pirate_sm.core.documents import Edit, FileKind, Place

LINE = "  - {command: RelaxRear, if: 'speed > 2 m/s'}  # 100 %, really: ünusual"


@pytest.fixture
def report() -> CheckReport:
    """An error with a story, a warning, a possibility, an allowed one, one of a whole file."""
    place = Place("missions/my mission.yaml", 12, 15)
    findings = (
        Finding(
            "step.maybe_impossible", Severity.ERROR, place, "RelaxRear can be refused: 50 %",
            fix="brake first", suggestion="RelaxFront", excerpt=LINE,
            related=((Place("missions/called.yaml", 3, 1), "called from here"),),
            story=("the mission begins", "RelaxRear is refused:\nwheels turn"), example="loss_1",
            edit=Edit(place, 24, "RelaxFront"),
        ),
        Finding("phase.unreachable", Severity.WARNING, Place("a.yaml", 3, 3), "lost", excerpt="x"),
        Finding("trigger.never", Severity.POSSIBLE, Place("a.yaml", 9, 3), "perhaps", excerpt="y"),
        Finding("chart.trap", Severity.WARNING, Place("a.yaml", 4, 3), "trap",
                allowed="it ends, here"),
        Finding("file", Severity.ERROR, Place("/tmp/gone.yaml"), "there is no such file"),
    )  # fmt: skip
    files = (
        CheckedFile("clean.yaml", FileKind.PIPE),
        CheckedFile("a.yaml", FileKind.MISSION),
        CheckedFile("missions/my mission.yaml", FileKind.MISSION),
    )
    return CheckReport(findings, files)


@pytest.fixture
def clean() -> CheckReport:
    return CheckReport((), (CheckedFile("clean.yaml", FileKind.PIPE),))


@pytest.fixture
def hostile() -> CheckReport:
    """Names and texts that try to be something else where they are shown."""
    nasty = "a]]><b>\0\x1b[31m\x85\u2028\ud800 ::error::x\r\n##[group]"
    place = Place("no\udcffway/<&>,:%\n.yaml", 1, 5)
    finding = Finding(
        "unknown-key", Severity.ERROR, place, nasty, fix=nasty, suggestion=nasty,
        excerpt=f"abc {nasty}", story=(nasty,), related=((place, nasty),), example=nasty,
        edit=Edit(place, 9, nasty, safe=True),
    )  # fmt: skip
    return CheckReport(
        (finding, finding.allow(nasty)), (CheckedFile(place.file, FileKind.MISSION),)
    )
