"""Panel files: what is shipped fits its robot, and every fault is told with its place."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core import library
from pirate_sm.core.documents import LoadError
from pirate_sm.core.loading import load_robot
from pirate_sm.robot.control_panel.panel_file import CommandButton, load_panel

ROOT = Path(__file__).resolve().parents[4]
PIRATE, NEWT = ROOT / "hardware_profiles" / "pirate_ii", ROOT / "tests" / "robots" / "newt"

GOOD = """\
format: 1
panel: small
device: Small
controls: {STOP: 1, A: 2, B: 3, FADER: 4}
buttons:
  STOP: {do: stop}
  A: {command: HoldNose}
  A+B: {word: near, twice: true}
  B: {answer: 1, hold: 500 ms}
"""


def faults(tmp_path: Path, old: str, new: str) -> list[str]:
    """What is said of the good panel with one text instead of another."""
    assert old in GOOD
    path = tmp_path / "small.yaml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(LoadError) as refused:
        load_panel(path, load_robot(NEWT))
    return [
        f"{p.place.line}:{p.place.column} {p.code}: {p.message} {p.expected} {p.suggestion}"
        for p in refused.value.problems
    ]


def test_the_shipped_panels_fit_their_robots() -> None:
    for path in library.panels():
        assert load_panel(path, load_robot(PIRATE)).panel == path.stem


def test_every_command_of_the_robot_that_moves_it_is_on_the_shipped_panel() -> None:
    robot = load_robot(PIRATE)
    panel = load_panel(ROOT / "panels" / "nanokontrol2.yaml", robot)
    given = {b.command for b in panel.buttons.values() if isinstance(b, CommandButton)}
    assert given == set(robot.profile.commands)
    assert panel.buttons["SET+R8"] == CommandButton(command="Reset", twice=True)


def test_no_fader_and_no_knob_of_the_shipped_panel_does_anything() -> None:
    panel = load_panel(ROOT / "panels" / "nanokontrol2.yaml", load_robot(PIRATE))
    continuous = {name for name in panel.controls if name.startswith(("FADER", "KNOB"))}
    assert len(continuous) == 16
    assert {part for name in panel.buttons for part in name.split("+")} & continuous == set()


def test_another_controller_for_another_robot_is_yaml_alone() -> None:
    panel = load_panel(NEWT / "pedals.yaml", load_robot(NEWT))
    assert panel.channel == 10
    assert panel.buttons["PAD_2"] == CommandButton(command="Rest")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("HoldNose", "HoldNoze", "7:16 panel.command: newt has no command 'HoldNoze'"),
        ("near", "nere", "8:15 panel.word: the detector of newt has no word 'nere'"),
        ("A+B", "A+C", "8:3 panel.button: there is no control 'C' one of STOP, A, B, FADER"),
        ("A+B", "A+A", "8:3 panel.button: a button cannot be held down and pressed"),
        ("FADER: 4", "FADER: 3", "4:40 panel.control: B sends the control change 3 already"),
        ("FADER: 4", "FADER: 128", "4:40 range: expected at most 127"),
        ("  STOP: {do: stop}\n", "", "5:1 panel.stop: no button stops the robot"),
        ("  STOP: {do", "  A+STOP: {do", "6:3 panel.stop: a stop needs one button alone"),
        ("{do: stop}", "{do: stop, hold: 1 s}", "6:3"),
        ("{do: stop}", "{do: stop, twice: true}", "6:3"),
        ("{do: stop}", "{do: halt}", "6:14"),
        ("{answer: 1,", "{anser: 1,", "9:7"),
        ("answer: 1", "answer: 0", "9:15"),
        ("500 ms", "500", "9:24"),
        ("device: Small", "devise: Small", "3:1"),
        ("A+B", "A +B", "8:3"),
    ],
)
def test_a_fault_is_told_with_its_place(tmp_path: Path, old: str, new: str, told: str) -> None:
    found = faults(tmp_path, old, new)
    assert any(each.startswith(told) for each in found), found


def test_a_misspelt_command_is_told_with_the_one_that_was_meant(tmp_path: Path) -> None:
    (fault,) = faults(tmp_path, "HoldNose", "HoldNoze")
    assert fault.endswith(" HoldNose")


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    assert len(faults(tmp_path, "{command: HoldNose}\n  A+B", "{command: Grip}\n  A+C")) == 2
