"""Files are changed by the edits of their findings; nothing else in them or near them changes."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from pathlib import Path

import pytest

from checking.small_missions import MISSION
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import FileChange, changes_of
from pirate_sm.core.documents import Edit, Place
from pirate_sm.core.errors import UsageError

SHORT = MISSION.replace("[ClampFront]", "ClampFront")
"""With one fault of which nobody can doubt what was meant."""

PROBABLY = MISSION.replace("ClampFront", "ClampFrnt")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "project"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def changes(*paths: str, unsafe: bool = False) -> list[FileChange]:
    return changes_of(check_paths(paths), paths, unsafe=unsafe)


def fix(*paths: str, unsafe: bool = False) -> int:
    """Change the files; return how many findings that removes."""
    found = changes(*paths, unsafe=unsafe)
    for change in found:
        change.write()
    return sum(change.fixed for change in found)


def test_only_what_is_wrong_is_changed_in_a_file(here: Path) -> None:
    wrong = SHORT.replace("go: e}", "go: [e]}  # über").replace("ok}", "ok}  # last")
    file = here / "m.yaml"
    file.write_bytes(f"\ufeff# first\n{wrong[:-1]}".replace("\n", "\r\n").encode())
    file.chmod(0o640)

    assert fix("m.yaml") == 2

    right = wrong.replace("do: ClampFront", "do: [ClampFront]").replace("[e]", "e")
    assert file.read_bytes().decode() == f"\ufeff# first\n{right[:-1]}".replace("\n", "\r\n")
    assert file.stat().st_mode & 0o777 == 0o640
    assert [each.name for each in here.iterdir()] == ["m.yaml"]


def test_what_was_probably_meant_is_changed_only_where_that_is_wanted(here: Path) -> None:
    file = here / "m.yaml"
    file.write_text(PROBABLY, encoding="utf-8")

    assert fix() == 0
    assert fix(unsafe=True) == 1
    assert file.read_text("utf-8") == MISSION


def test_a_name_in_quotes_is_replaced_with_them(here: Path) -> None:
    file = here / "m.yaml"
    file.write_text(PROBABLY.replace("ClampFrnt", '"ClampFrnt"').replace("go:", "'goo':"), "utf-8")

    assert fix(unsafe=True) == 1
    assert fix(unsafe=True) == 1  # the command is looked at once the keys are right
    assert file.read_text("utf-8") == MISSION


@pytest.mark.parametrize("value", ["&step ClampFront", "ClampFront\n    # first\n    twice"])
def test_a_value_with_an_anchor_or_of_several_lines_is_left_alone(here: Path, value: str) -> None:
    block = f"  a:\n   do: {value}\n   go: e"
    (here / "m.yaml").write_text(MISSION.replace("  a: {do: [ClampFront], go: e}", block), "utf-8")

    assert check_paths(["m.yaml"]).open
    assert changes("m.yaml", unsafe=True) == []


def test_an_allowed_finding_is_left_alone(here: Path) -> None:
    file = here / "m.yaml"
    unreached = "  b: {go: e}  # pirate: allow phase.unreachable: later"
    file.write_text(MISSION.replace("ends:", f"{unreached}\nends:"), "utf-8")
    report = check_paths(["m.yaml"])
    [allowed] = report.allowed
    edit = Edit(allowed.place, allowed.place.column + 1, "c", safe=True)

    assert (
        changes_of(replace(report, findings=(replace(allowed, edit=edit),)), [], unsafe=True) == []
    )


def test_of_edits_that_overlap_one_is_made(here: Path) -> None:
    (here / "m.yaml").write_text(SHORT, "utf-8")
    report = check_paths(["m.yaml"])
    [finding] = report.open
    place = replace(finding.place, column=finding.place.column + 3)
    other = replace(finding, edit=Edit(place, place.column + 2, "other", safe=True))

    [change] = changes_of(replace(report, findings=(finding, other)), [], unsafe=False)

    assert change.fixed == 1
    assert change.after == SHORT.replace("ClampFront", "ClaotherFront")


def test_a_line_that_has_changed_since_it_was_checked_is_left_alone(here: Path) -> None:
    file = here / "m.yaml"
    file.write_text(SHORT, "utf-8")
    report = check_paths(["m.yaml"])
    file.write_text(MISSION, "utf-8")

    assert changes_of(report, [], unsafe=True) == []


def test_a_file_that_is_only_used_is_not_changed(here: Path) -> None:
    (here / "own").mkdir()
    (here / "own" / "m.yaml").write_text(
        MISSION.replace("ClampFront", "{call: ../o.yaml}"), "utf-8"
    )
    (here / "o.yaml").write_text(SHORT.replace("mission: m", "mission: o"), "utf-8")

    assert "o.yaml" in {each.place.file for each in check_paths(["own"]).open}
    assert changes("own", unsafe=True) == []
    assert len(changes(unsafe=True)) == 1


@pytest.mark.parametrize("paths", [(), (".",)])
def test_no_link_out_of_the_checked_folder_is_followed(here: Path, paths: tuple[str, ...]) -> None:
    outside = here.parent / "m.yaml"
    outside.write_text(SHORT, "utf-8")
    (here / "link.yaml").symlink_to(outside)

    assert check_paths(paths).open
    assert changes(*paths, unsafe=True) == []


def test_a_link_that_is_named_itself_is_followed_and_stays_one(here: Path) -> None:
    outside = here.parent / "m.yaml"
    outside.write_text(SHORT, "utf-8")
    (here / "link.yaml").symlink_to(outside)

    assert fix("link.yaml") == 1
    assert (here / "link.yaml").is_symlink()
    assert outside.read_text("utf-8") == MISSION


def test_a_link_within_the_checked_folder_stays_one(here: Path) -> None:
    (here / "m.yaml").write_text(SHORT, "utf-8")
    (here / "link.yaml").symlink_to("m.yaml")

    assert fix() == 1
    assert (here / "link.yaml").is_symlink()
    assert (here / "m.yaml").read_text("utf-8") == MISSION


def test_a_shipped_file_that_is_checked_by_its_name_is_not_changed() -> None:
    report = check_paths(["mitre_bend"])
    place = Place(report.files[-1].name, 1, 1)
    edit = Edit(place, 2, "x", safe=True)
    excerpt = Path(place.file).read_text("utf-8").splitlines()[0]
    found = Finding("syntax", Severity.ERROR, place, "wrong", excerpt=excerpt, edit=edit)

    assert changes_of(replace(report, findings=(found,)), ["mitre_bend"], unsafe=True) == []


def test_a_file_that_cannot_be_written_stays_as_it_was(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "m.yaml").write_text(SHORT, "utf-8")
    [change] = changes("m.yaml")

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UsageError, match="cannot be changed: No space left on device"):
        change.write()

    assert (here / "m.yaml").read_text("utf-8") == SHORT
    assert [each.name for each in here.iterdir()] == ["m.yaml"]
