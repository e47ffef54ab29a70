"""Times, speeds and ways are judged by the control that is in force at each step and wait."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import check_mission

from ..robots import PIRATE, changed

HELD = "starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}"
CREEPING = """\
controls:
  creeping: &creeping
    actuation:
      FrontWheelsState:
        DrivingForward: {wheel_1: 20 mm/s, wheel_2: -20 mm/s, wheel_3: 20 mm/s}
        DrivingBackward: {wheel_1: -20 mm/s, wheel_2: 20 mm/s, wheel_3: -20 mm/s}
      RearWheelsState:
        DrivingForward: {wheel_4: -20 mm/s, wheel_5: 20 mm/s, wheel_6: -20 mm/s}
        DrivingBackward: {wheel_4: 20 mm/s, wheel_5: -20 mm/s, wheel_6: 20 mm/s}
  hardly:
    actuation:
      FrontWheelsState:
        DrivingForward: {wheel_1: 5 mm/s, wheel_2: -5 mm/s, wheel_3: 5 mm/s}
      RearWheelsState:
        DrivingForward: {wheel_4: -5 mm/s, wheel_5: 5 mm/s, wheel_6: -5 mm/s}
""".replace(" &creeping", "")


def findings(folder: Path, do: str, *lines: str) -> list[Finding]:
    """What is said of the mission; the robot has a control under which a command is never done."""
    if not (folder / PIRATE.name).exists():
        changed(PIRATE, folder, "profile.yaml", ("controls:\n", CREEPING))
    text = "\n".join(
        ("format: 1", "mission: m", "robot: ./pirate_ii", "pipe: straight_113", HELD, *lines,
         "start: a", "phases:", f"  a: {{do: [{do}], go: e}}", "ends: {e: {succeed: ok}}", "")
    )  # fmt: skip
    file = folder / "m.yaml"
    file.write_text(text, encoding="utf-8")
    return [each for each in check_mission(file).findings if each.code != "robot.never_done"]


def wait(condition: str, within: str = "10 s") -> str:
    return f"{{wait: [{{when: {condition}}}], within: {{time: {within}}}}}"


ALIGNED = "    done: {kind: aligned, slots: [rotate], within: 3 deg}"


@pytest.mark.parametrize(
    ("done", "beyond"), [(ALIGNED, True), ("    done: {kind: accepted}", False)]
)
def test_a_joint_may_still_be_where_it_was_if_nothing_waits_for_it(
    tmp_path: Path, done: str, beyond: bool
) -> None:
    text = (PIRATE / "profile.yaml").read_text("utf-8")
    swaps = [(ALIGNED, done.replace("    done", "    #done")) for _ in range(text.count(ALIGNED))]
    changed(PIRATE, tmp_path, "profile.yaml", *swaps, ("controls:\n", CREEPING))
    file = tmp_path / PIRATE.name / "profile.yaml"
    file.write_text(file.read_text("utf-8").replace("    #done", "    done"), "utf-8")

    found = findings(tmp_path, f"RelaxFront, AlignLeft, AlignRight, {wait('phi < -30 deg')}")

    assert [each.code for each in found if each.code == "condition.beyond"] == (
        ["condition.beyond"] * beyond
    )


def test_the_usual_timeout_of_a_control_is_not_said_to_be_here(tmp_path: Path) -> None:
    slow = ("    no_load_speed: ", "    no_load_speed: 0.0001 rad/s  # "), ("controls:\n", CREEPING)
    changed(PIRATE, tmp_path, "profile.yaml", *slow)

    usual, given = (
        next(e.message for e in findings(tmp_path, do) if e.code == "step.timeout")
        for do in ("{control: exp_3a}", "{control: exp_3a, timeout: 9 s}")
    )

    assert usual.endswith("and the default timeout is 10 s")
    assert given.endswith("and the timeout here is 9 s")


@pytest.mark.parametrize(
    ("control", "condition", "beyond"),
    [
        ("none", "change(odometry) > 500 mm", False),
        ("exp_3a", "change(odometry) > 500 mm", False),
        ("creeping", "change(odometry) > 500 mm", True),
        ("creeping", "change(odometry) > 150 mm", False),
        ("none", "speed > 60 mm/s", False),
        ("creeping", "speed > 60 mm/s", True),
        ("creeping", "speed > 18 mm/s", False),
    ],
)
def test_what_is_out_of_reach_depends_on_the_control_in_force(
    tmp_path: Path, control: str, condition: str, beyond: bool
) -> None:
    do = f"{{control: {control}}}, DriveForward, {wait(condition)}, Brake"

    found = [each for each in findings(tmp_path, do) if each.code == "condition.beyond"]

    assert len(found) == beyond
    assert all("under the control 'creeping'" in each.message for each in found)


def test_a_control_that_is_over_limits_nothing_any_more(tmp_path: Path) -> None:
    do = f"{{control: creeping}}, {{control: none}}, DriveForward, {wait('speed > 60 mm/s')}, Brake"

    assert [each for each in findings(tmp_path, do) if each.code == "condition.beyond"] == []


def test_the_control_at_the_head_of_a_mission_counts(tmp_path: Path) -> None:
    do = f"DriveForward, {wait('speed > 60 mm/s')}, Brake"

    found = findings(tmp_path, do, "control: creeping")

    assert [each.code for each in found] == ["condition.beyond"]
    assert findings(tmp_path, do) == []


def test_a_way_that_takes_longer_than_the_mission_may_is_out_of_reach(tmp_path: Path) -> None:
    far = wait("change(odometry) > 500 mm", "60 s")
    do = f"{{control: creeping}}, DriveForward, {far}, Brake"

    found, late = findings(tmp_path, do, "time_limit: 10 s")

    assert (found.code, late.code) == ("condition.beyond", "limit.beyond")
    assert "the mission ends after 10 s" in found.message
    assert findings(tmp_path, do, "time_limit: 60 s") == []


def test_a_wait_that_counts_on_is_not_judged_by_what_it_drives_itself(tmp_path: Path) -> None:
    far = wait("change(odometry) > 500 mm")
    anew = f"{{control: creeping}}, DriveForward, {far}, Brake"
    on = anew.replace("{wait:", "{counts_on: true, wait:")

    assert [each.code for each in findings(tmp_path, anew)] == ["condition.beyond"]
    assert findings(tmp_path, on) == []


def test_a_wait_in_which_two_controls_may_be_in_force_has_the_reach_of_the_faster(
    tmp_path: Path,
) -> None:
    switch = "{choose: [{if: gamma_1 > 5 deg, do: [{control: creeping}]}]}"
    do = f"{switch}, DriveForward, {wait('speed > 60 mm/s')}, Brake"

    assert [each for each in findings(tmp_path, do) if each.code == "condition.beyond"] == []


def test_a_command_that_cannot_be_done_under_the_control_in_force_is_an_error(
    tmp_path: Path,
) -> None:
    (found,) = (
        each
        for each in findings(tmp_path, "{control: hardly}, DriveForward, Brake")
        if each.code == "step.timeout"
    )

    assert found.severity.word == "error"
    assert "DriveForward cannot be seen to be done" in found.message
    assert "under the control 'hardly'" in found.message
    usual = findings(tmp_path, "{control: hardly}, {control: none}, DriveForward, Brake")
    assert [each.code for each in usual if each.code == "step.timeout"] == []


def test_a_control_that_turns_wheels_the_other_way_is_refused(tmp_path: Path) -> None:
    changed(
        PIRATE, tmp_path, "profile.yaml",
        ("controls:\n", CREEPING.replace("wheel_1: 20 mm/s", "wheel_1: -20 mm/s")),
    )  # fmt: skip

    found = findings(tmp_path, "{control: creeping}, DriveForward, Brake")

    assert {each.code for each in found} == {"robot.control"}
    assert any("turns the other way than under `actuation`" in each.message for each in found)


@pytest.mark.parametrize(
    ("condition", "said"),
    [
        ("speed >= -3 m/s", "'speed >= -3 m/s' is always true: without a load the robot drives"),
        ("odometry >= -100 m", "'odometry >= -100 m' is always true: the pipe is 1.14 m long"),
        ("speed >= -5 mm/s", ""),  # it may be pushed back faster
        ("odometry >= -200 mm", ""),  # it may have driven back before
        ("known(speed) or speed < -3 m/s", ""),
    ],
)
def test_a_condition_that_no_reachable_value_makes_false_is_found(
    tmp_path: Path, condition: str, said: str
) -> None:
    do = f"DriveForward, {{wait: [{{when: {condition}}}], within: {{time: 10 h}}}}"

    found = [each for each in findings(tmp_path, do) if each.code == "condition.beyond"]

    assert [each.message[: len(said)] for each in found] == [said] * bool(said)
