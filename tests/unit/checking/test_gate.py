"""What is certainly wrong with a mission keeps it from being run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from checking.robots import NEWT, ROOT, changed
from checking.small_missions import MISSION
from pirate_sm.checking import gate
from pirate_sm.checking.gate import CheckError, pass_or_raise
from pirate_sm.checking.mission import check_mission
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.robot.calibration_files import with_zeros
from pirate_sm.running.wiring import Order, prepare


def passes(folder: Path, text: str) -> None:
    (folder / "m.yaml").write_text(text, encoding="utf-8")
    pass_or_raise(load_mission(folder / "m.yaml"))


def test_a_clean_mission_passes(tmp_path: Path) -> None:
    passes(tmp_path, MISSION)


def test_an_error_is_told_whole_and_stops_it(tmp_path: Path) -> None:
    with pytest.raises(CheckError) as caught:
        passes(tmp_path, MISSION.replace("[ClampFront]", "[ClampFront, ClampFront]"))

    assert caught.value.exit_code == 2
    assert [each.code for each in caught.value.findings] == ["step.unneeded"]
    text = str(caught.value)
    assert "m.yaml:6:24: error [step.unneeded]" in text
    assert text.endswith(
        "\n1 mission checked: 1 error\n"
        "nothing has moved; check=False runs the mission all the same"
    )  # fmt: skip


def test_a_warning_does_not_stop_it(tmp_path: Path) -> None:
    passes(tmp_path, MISSION.replace("phases:\n", "phases:\n  lost: {go: e}\n"))


def test_what_is_allowed_does_not_stop_it(tmp_path: Path) -> None:
    wrong = "{do: [ClampFront, ClampFront], on_failure: e, go: e}"
    text = MISSION.replace("{do: [ClampFront], go: e}", wrong)
    with pytest.raises(CheckError):
        passes(tmp_path, text)

    passes(tmp_path, text.replace(wrong, f"{wrong}  # pirate: allow step.unneeded: so"))


DRIVE_ON = partial(load_mission, ROOT / "sequences" / "drive_on.yaml")


def elsewhere() -> LoadedMission:
    loaded = DRIVE_ON()
    return replace(loaded, program=replace(loaded.program, start_configuration=1))


def with_other_zeros() -> LoadedMission:
    loaded = DRIVE_ON()
    return replace(loaded, robot=with_zeros(loaded.robot, {"gamma_1": 0.1}))


@pytest.mark.parametrize(
    ("other", "explored"),
    [
        (DRIVE_ON, 1),
        (partial(DRIVE_ON, settings={"way": "300 mm"}), 2),
        (partial(DRIVE_ON, pipe="mitre_90"), 2),
        (elsewhere, 2),
        (with_other_zeros, 2),
    ],
)
def test_only_the_same_mission_is_not_explored_again(
    other: Callable[[], LoadedMission], explored: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    check, seen = check_mission.check_loaded, []
    gate._CHECKED.clear()
    monkeypatch.setattr(
        check_mission, "check_loaded", lambda loaded: seen.append(loaded) or check(loaded)
    )

    for each in (DRIVE_ON(), other()):
        assert pass_or_raise(each) == check(each).findings

    assert len(seen) == explored


@pytest.mark.parametrize(
    ("code", "old", "new"),
    [
        ("robot.wheels_fight", "Ahead: {drive_a: 80 %", "Ahead: {drive_a: -80 %"),
        ("robot.clamp_side", "NoseHeld: {fold_neck: -50 %", "NoseHeld: {fold_neck: 50 %"),
        ("robot.direction", "part: tail, direction: -1", "part: tail, direction: 1"),
        ("robot.never_done", "share: 10 %}, timeout", "share: 90 %}, timeout"),
        ("robot.reference", "angle: roll_b", "angle: roll_a"),
    ],
)
def test_an_error_of_the_robot_stops_every_mission_of_it(
    code: str, old: str, new: str, tmp_path: Path
) -> None:
    robot = changed(NEWT, tmp_path, "profile.yaml", (old, new))

    with pytest.raises(CheckError) as caught:
        pass_or_raise(load_mission(robot / "patrol.yaml"))

    assert code in {each.code for each in caught.value.findings}
    assert {each.place.file for each in caught.value.findings} == {str(robot / "profile.yaml")}
    prepare(Order(str(robot / "patrol.yaml"), backend="trace", check=False))


def test_an_error_that_the_robot_allows_does_not_stop_its_missions(tmp_path: Path) -> None:
    line = "    - {name: right_fore, part: nose, direction: -1, mass: 15 g, angle: roll_b, speed: "
    why = "  # pirate: allow robot.reference: the encoder is broken"
    swap = f"{line}spin_b}}", f"{line.replace('roll_b', 'roll_a')}spin_a}}{why}"
    robot = changed(NEWT, tmp_path, "profile.yaml", swap)

    pass_or_raise(load_mission(robot / "patrol.yaml"))


WAITS = MISSION.replace("robot: pirate_ii\n", "robot: pirate_ii\npipe: straight_113\n").replace(
    "go: e}", "wait: [{when: detector == close, go: e}], within: {time: 9 s, go: e}}"
)


@pytest.mark.parametrize("detector", ["sim", "odometry", "vision:synthetic", None])
def test_a_word_about_a_bend_stops_a_mission_in_a_straight_pipe(
    tmp_path: Path, detector: str | None
) -> None:
    (tmp_path / "m.yaml").write_text(WAITS, encoding="utf-8")

    with pytest.raises(CheckError, match="and the pipe has none"):
        load_checked(tmp_path, detector)


@pytest.mark.parametrize("detector", ["operator", "socket:/tmp/words"])
def test_a_person_or_a_program_may_say_the_word_anywhere(tmp_path: Path, detector: str) -> None:
    (tmp_path / "m.yaml").write_text(WAITS, encoding="utf-8")

    load_checked(tmp_path, detector)


def load_checked(folder: Path, detector: str | None) -> None:
    prepare(Order(str(folder / "m.yaml"), detector=detector, check=True))
