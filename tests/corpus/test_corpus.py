"""Every seeded fault is found, with its code at its line, and nothing else is said of its files."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.checking import catalogue
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.findings import Finding

from .made import MADE, Made, mission_with_faults
from .seeding import HERE, ROBOTS, ROOT, Case, cases, copied

CASES = cases()
NEWT = {"newt", "pedals", "stroll"}
"""Bases that are about the second robot."""
SLOW = "names: repeats a call more often than can be written out"
FIRST = {
    case.seeds: case
    for case in sorted(
        (case for case in reversed(CASES) if case.name != SLOW),
        key=lambda case: case.base in NEWT or "newt" in str(case.files),
    )
}
"""The first case of each code, of the second robot where it has one: that robot is small."""
BASES = [*ROBOTS, *sorted(path.name for path in (HERE / "bases").iterdir())]

NOT_SEEDED = {
    "check.failed": "is an internal error; test_project.py makes one",
    "check.untrusted": "is about settings; test_settings.py seeds it",
    "chart.invalid": "every chart that its outline accepts is built without names of its own",
    "more": "stands beside the faults that are too many to be shown: see below",
    "experiment.name": "test_check_experiment.py seeds it: layers above know experiments",
    "experiment.robot": "test_check_experiment.py seeds it",
    "experiment.unit": "test_check_experiment.py seeds it",
    **dict.fromkeys(
        [code for code in catalogue.entries() if code.startswith("campaign.")],
        "test_campaign_file.py seeds it: layers above know campaigns",
    ),
    **dict.fromkeys(
        [code for code in catalogue.entries() if code.startswith("scene.")],
        "test_check.py seeds it: layers above know scenes",
    ),
    "route.undrivable": "comes of a route that is asked for: test_new_route.py",
    "rehearsal.failed": "comes of a run in the simulator, not of a file",
    "rehearsal.at_once": "comes of a run in the simulator, not of a file",
}
"""Codes that no single fault of a file brings about, and why."""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to check, with the second robot beside it."""
    (tmp_path / "newt").mkdir()
    copied("newt", tmp_path / "newt")
    folder = tmp_path / "case"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def shown(finding: Finding) -> tuple[str, str, int]:
    return finding.code, finding.place.file, finding.place.line


@pytest.mark.parametrize("base", BASES)
def test_what_the_faults_are_put_into_is_clean(base: str, here: Path) -> None:
    copied(base, here)

    assert check_paths(["."]).findings == ()


@pytest.mark.parametrize("case", thorough_but(FIRST.values(), CASES), ids=lambda case: case.name)
def test_a_seeded_fault_is_found_and_nothing_else(case: Case, here: Path) -> None:
    expected = case.write(here)
    assert len(expected) == 1, "one fault a case"

    findings = check_paths(case.check).findings
    assert [shown(each) for each in findings] == list(expected), "\n".join(
        f"{each.place} [{each.code}] {each.message}" for each in findings
    )
    [finding] = findings
    usual = catalogue.entry_of(finding.code).severity
    assert finding.severity.word == (case.severity or usual)
    assert finding.message
    assert finding.fix or catalogue.entry_of(finding.code).fix


@pytest.mark.parametrize("made", MADE.values(), ids=MADE.keys())
def test_a_fault_that_is_made_is_found_and_nothing_else(
    made: Made, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made.make(here)
    for limit, value in made.limits.items():
        monkeypatch.setattr(limit, value)

    found = check_paths([made.check]).findings
    assert [shown(each) for each in found] == [made.finds], [each.message for each in found]


@pytest.mark.parametrize("faults", [250, 1000])
def test_faults_that_are_not_shown_are_counted(faults: int, here: Path) -> None:
    (here / "m.yaml").write_text(mission_with_faults(faults), encoding="utf-8")

    codes = Counter(each.code for each in check_paths(["."]).findings)
    assert codes["more"] == 1
    assert codes.keys() == {"more", "step"}


def test_every_code_is_seeded_twice_with_different_faults() -> None:
    seeded = Counter(case.seeds for case in CASES)
    seeded.update(made.finds[0] for made in MADE.values())
    assert seeded.total() >= 80
    assert len({case.name for case in CASES}) == len(CASES)
    assert set(NOT_SEEDED) <= set(catalogue.entries())
    too_few = {code for code in catalogue.entries() if seeded[code] < 2} - NOT_SEEDED.keys()
    assert too_few == set()


def test_the_3d_sequence_of_the_thesis_is_refused_for_its_three_reasons(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(ROOT)
    file = "tests/missions/enter_3d_as_printed.yaml"
    lines = (ROOT / file).read_text("utf-8").splitlines()

    found = check_paths([file]).findings

    assert [(each.code, lines[each.place.line - 1].strip()) for each in found] == [
        ("step.unneeded", "- ClampRear"),
        ("step.impossible", "- UnclampRear"),
        ("mission.command", "- AlignOther"),
    ]
    assert found[0].place.line == 1 + lines.index("      - ToggleLight") + 1
    assert found[1].message.startswith("UnclampRear (RelaxRear) is refused as impossible")
    assert "AlignLeft or AlignRight" in found[2].message
    steps = [line.strip().removeprefix("- ") for line in lines if line.startswith("      - ")]
    assert steps == [
        "ClampRear", "ToggleLight", "ClampRear", "AlignRight",
        "UnclampRear", "ClampFront", "AlignOther", "DriveForward",
    ]  # fmt: skip
