"""Phases that are moved into a mission of their own do what they did before."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.checking.exploring import explore
from pirate_sm.checking.mission_behaviour import Abilities, abilities_of
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.core.on_disk import unsaved
from pirate_sm.views.editor.extracted_mission import Extracted, extracted, selected_phases
from tests.representative import thorough_but

from .client import checks_as_the_command

ROOT = Path(__file__).resolve().parents[4]
DRIVE = (ROOT / "tests" / "mistakes" / "bases" / "drive.yaml").read_text("utf-8")
SHIPPED = sorted((ROOT / "sequences").glob("*.yaml"))
FEW = [ROOT / "sequences" / f"{name}.yaml" for name in ("mitre_bend", "exp_2c_clamp")]


def taken_out(path: Path, names: list[str], text: str | None = None) -> Extracted:
    if text is not None:
        path.write_text(text)
    return extracted(load_mission(path), names, f"{path.stem}_part")


def in_both(path: Path, made: Extracted) -> Any:
    new = path.with_name(f"{path.stem}_part.yaml")
    return unsaved({str(path): made.caller.encode(), str(new): made.called.encode()})


def test_the_text_is_moved_with_its_comments_and_its_parameters(tmp_path: Path) -> None:
    text = DRIVE.replace("  halt: {", "  # Out there.\n  halt: {").replace(
        "  drive:\n", "  drive:  # the way\n"
    )
    made = taken_out(tmp_path / "drive.yaml", ["drive"], text)

    assert "start: drive\nphases:\n  drive: {do: [{call: drive_part, " in made.caller
    assert "with: {way: $way, give_up: $give_up}, on_failure: regrip}], go: halt}\n" in made.caller
    assert "\n  # Out there.\n  halt: {" in made.caller
    assert "  drive:  # the way\n    do:\n      - ClampFront\n" in made.called
    assert "# Out there" not in made.called
    assert "  way: {type: length, default: 200 mm, min: 50 mm" in made.called
    assert made.called.endswith(
        'ends:\n  halt: {succeed: On to halt}\n  regrip: {fail: "{cause}"}\n'
    )


def test_states_are_promised_only_if_all_was_explored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = taken_out(tmp_path / "drive.yaml", ["halt"], DRIVE)
    monkeypatch.setattr(explore, "MOST_WORK", 100)
    monkeypatch.setattr(explore, "_SHARED", deque())
    part = taken_out(tmp_path / "drive.yaml", ["halt"], DRIVE)

    assert "BendingState: " in whole.called
    assert "starts_in: {}\n" in part.called


@pytest.mark.parametrize(
    ("names", "change", "why"),
    [
        (["drive", "halt", "regrip"], ("", ""), "no phase would be left"),
        (["regrip"], ("", ""), "all failures of this mission lead to 'regrip'"),
        (["drive"], ("give_up, go: regrip", "give_up, go: lost_grip"), "lead to halt, lost_grip"),
        (["drive"], ("    within: ", "    counts_on: true\n    within: "), "`counts_on`"),
        (["drive"], ("    within: ", "    resume: halt\n    within: "), "`resume`"),
        (["halt", "regrip"], ("on_failure: regrip\n", ""), "lead to 'regrip' and 'halt'"),
    ],
)
def test_what_a_call_cannot_do_is_refused(
    names: list[str], change: tuple[str, str], why: str, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match=re.escape(why)):
        taken_out(tmp_path / "drive.yaml", names, DRIVE.replace(*change))


def selections(names: list[str]) -> Iterator[list[str]]:
    """Every run of phases that stand below each other."""
    for first in range(len(names)):
        for last in range(first + 1, len(names) + 1):
            yield names[first:last]


def can(abilities: Abilities, part: str, due: Any = None) -> Any:
    """What a mission can do, in the names that its phases had before some were moved.

    A trigger of the last step leads to an end, or to the next step where that is after the call.
    """

    def before(name: str) -> str:
        return re.sub(rf"\w+/{part}\.", "", name)

    def renamed(found: Any) -> dict[tuple[str, str], Any]:
        return {(before(phase), name): what for (phase, name), what in found.items()}

    triggers = {
        key: due[1].get(key)
        if due and it.go == ("continue",)
        else (it.text, (*map(before, it.go),))
        for key, it in renamed(abilities.triggers).items()
    }
    return (
        renamed(abilities.commands),
        triggers,
        abilities.outcomes.keys(),
        renamed(abilities.failures),
        {key: before(go) for key, go in renamed(abilities.faults).items()},
        abilities.broken,
        abilities.success and abilities.success.commands,
    )


@pytest.mark.parametrize("path", thorough_but(FEW, SHIPPED), ids=lambda path: path.stem)
def test_a_shipped_mission_can_do_the_same_as_before(path: Path) -> None:
    loaded, part = load_mission(path), f"{path.stem}_part"
    names = [*loaded.mission.phases]
    due = can(abilities_of(loaded), part)
    found = {each.code for each in checks_as_the_command([str(path)]).open}
    for chosen in selections(names):
        try:
            made = taken_out(path, chosen)
        except UsageError:
            continue
        with in_both(path, made):
            assert can(abilities_of(load_mission(path)), part, due) == due, chosen
            report = checks_as_the_command([str(path)])
            assert {each.code for each in report.open} <= found, chosen
        assert made.caller.count("\n") < loaded.documents[0].text.count("\n") + 2


def test_phases_are_selected_by_the_lines_that_they_have(tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    path.write_text(DRIVE)
    document = load_mission(path).documents[0]

    def between(first: str, last: str) -> list[str]:
        return selected_phases(document, DRIVE.index(first), DRIVE.index(last))

    assert between("  drive:", "  halt:") == ["drive"]
    assert between("ClampFront", "halt: {") == ["drive", "halt"]
    assert between("format", "mission") == []
    assert between("regrip:\n", "ends:") == ["regrip"]
