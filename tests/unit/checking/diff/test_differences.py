"""Two small versions of a mission each: what the newer one can do and the older one cannot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from representative import MISSIONS, thorough_but

from pirate_sm.checking.mission_behaviour import abilities_of
from pirate_sm.checking.mission_differences import MissionDifference, compare
from pirate_sm.core.loading import load_mission

ROOT = Path(__file__).resolve().parents[4]
SHIPPED = sorted(path.stem for path in (ROOT / "sequences").glob("*.yaml"))

OLD = """\
format: 1
mission: m
robot: pirate_ii
start: grip
phases:
  grip:
    do: [ClampFront, {command: ClampRear, retry: 1}]
    on_failure: sorry
    wait: [{when: detector == close, held: 200 ms, go: halt}]
    within: {time: 5 s, go: sorry}
  halt: {do: [{command: Brake, unneeded: skip}, ToggleLighting], on_failure: sorry, go: good}
  sorry: {do: [{command: Brake, unneeded: skip}], on_failure: bad, go: bad}
ends:
  good: {succeed: There}
  bad: {fail: "Not there: {cause}"}
"""


def compared(folder: Path, *replacements: tuple[str, str]) -> MissionDifference:
    new = OLD
    for before, after in replacements:
        assert before in new
        new = new.replace(before, after)
    found = []
    for name, text in (("old", OLD), ("new", new)):
        file = folder / f"{name}.yaml"
        file.write_text(text, encoding="utf-8")
        found.append(abilities_of(load_mission(file)))
    return compare(*found)


def told(difference: MissionDifference) -> list[str]:
    return [f"{each.kind}: {each.text}" for each in difference.changes]


@pytest.mark.parametrize(
    "replacement",
    [
        ("held: 200 ms", "held: 0.2 s"),
        ("start: grip", "description: says more  # than before\nstart: grip"),
        ("[ClampFront,", "[ClampFront, {command: ToggleLighting, if: LightingState == On},"),
    ],
    ids=["another unit", "other words", "a step whose turn never comes"],
)
def test_what_can_do_the_same_does_not_differ(tmp_path: Path, replacement: tuple[str, str]) -> None:
    difference = compared(tmp_path, replacement)

    assert difference.same
    assert difference.changes == ()


def test_other_names_are_told_and_are_no_difference(tmp_path: Path) -> None:
    difference = compared(tmp_path, ("sorry", "pity"), ("bad", "worse"))

    assert difference.same
    assert told(difference) == [
        "renamed: the phase 'sorry' is called 'pity' now",
        "renamed: the end 'bad' is called 'worse' now",
    ]


def test_a_phase_that_is_reached_no_more_is_lost_with_what_only_it_gave(tmp_path: Path) -> None:
    assert told(compared(tmp_path, ("go: halt", "go: good"))) == [
        "lost: the phase 'halt' can no longer be reached; it gave ToggleLighting; "
        "now nothing gives ToggleLighting",
        "changed: in 'grip' 'detector == close for 0.2 s' leads to 'good'; before to 'halt'",
        "changed: success takes at least 2 commands and 6 events; before 3 commands and 8 events",
    ]


def test_a_command_that_only_the_new_version_gives_is_gained(tmp_path: Path) -> None:
    difference = compared(tmp_path, ("ToggleLighting]", "ToggleLighting, RelaxRear]"))

    (gained,) = difference.of("gained")
    assert (gained.about, gained.phase, gained.name) == ("command", "halt", "RelaxRear")
    assert gained.text == "RelaxRear can be given in 'halt'; before, nothing gave it"


def test_without_its_retry_a_command_that_fails_ends_the_mission(tmp_path: Path) -> None:
    assert told(compared(tmp_path, (", retry: 1", ""))) == [
        "changed: ClampRear in 'grip' is given on other terms: as usual; before: retry 1",
        "changed: where ClampRear fails in 'grip' and nothing else goes wrong, it ends in 'bad'; "
        "before in 'bad' or 'good'",
    ]


def test_a_failure_that_nothing_handles_any_more_leads_to_the_safe_stop(tmp_path: Path) -> None:
    assert (
        "gained: it can end in the safe stop, as nothing handles a failure or a fault"
        in told(compared(tmp_path, ("    on_failure: sorry\n", "")))
    )  # fmt: skip


@pytest.mark.parametrize(
    ("replacement", "sentence"),
    [
        (
            ("time: 5 s", "time: 6 s"),
            "changed: the wait of 'grip' ends by its limit of 6 s; before by its limit of 5 s",
        ),
        (
            ("wait: [{", "wait: [{operator: go, go: halt}, {"),
            "gained: the wait of 'grip' can end by 'operator: go', which leads to 'halt'",
        ),
        (
            ("format: 1", "format: 1\non_fault: [{fault: robot.stuck, go: sorry}]"),
            "gained: the fault robot.stuck leads to 'sorry'; before: stops the mission",
        ),
        (
            ("format: 1", "format: 1\nallow_unclamp: it stands on the floor"),
            "lost: the rule never_let_go is no longer watched",
        ),
        (("format: 1", "format: 1\ntime_limit: 60 s"), "changed: time limit: 60 s; before: none"),
        (("format: 1", "format: 1\ncontrol: exp_3a"), "changed: control: exp_3a; before: none"),
        (("{succeed: There}", "{fail: There}"), "lost: nothing leads to success any more"),
        (
            ("good: {succeed: There}", "good: {fail: There}"),
            "changed: the end 'good' fails: There; before: succeeds: There",
        ),
    ],
)  # fmt: skip
def test_each_difference_has_its_sentence(
    tmp_path: Path, replacement: tuple[str, str], sentence: str
) -> None:
    assert [sentence] == [
        each for each in told(compared(tmp_path, replacement)) if each == sentence
    ]


def test_backwards_what_was_gained_is_lost(tmp_path: Path) -> None:
    compared(tmp_path, ("go: halt", "go: good"))
    old, new = (abilities_of(load_mission(tmp_path / f"{n}.yaml")) for n in ("old", "new"))

    forth, back = compare(old, new), compare(new, old)

    assert {each.name for each in forth.of("lost")} == {each.name for each in back.of("gained")}
    assert len(forth.changes) == len(back.changes)


def test_rules_come_in_the_order_of_their_names(tmp_path: Path) -> None:
    compared(tmp_path)
    old = abilities_of(load_mission(tmp_path / "old.yaml"))
    names = [f"rule_{number}" for number in range(9)]

    changes = compare(old, replace(old, rules=frozenset(names))).of("gained")

    assert [each.name for each in changes] == names


def test_what_was_cut_off_is_said(tmp_path: Path) -> None:
    compared(tmp_path)
    whole = abilities_of(load_mission(tmp_path / "old.yaml"))
    part = replace(whole, complete=False)

    assert compare(whole, whole).cut_off == ()
    assert compare(part, whole).cut_off == ("old",)
    assert compare(part, part).cut_off == ("old", "new")


@pytest.mark.parametrize("name", thorough_but(MISSIONS, SHIPPED))
def test_every_shipped_mission_can_do_what_it_can_do(name: str) -> None:
    able = abilities_of(load_mission(ROOT / "sequences" / f"{name}.yaml"))

    assert able.success is not None
    assert compare(able, able).changes == ()
