"""Each contradiction in a profile that loads is told once and at its place."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.checking.findings import Severity
from pirate_sm.checking.robot.check_robot import (
    ERROR_RULES,
    RULES,
    check_robot,
    robot_errors,
    robot_findings,
)
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.loading import load_robot

from ..robots import NEWT, PIRATE, changed, told

STUCK = "Crawl in (Ahead, Astern) and abs(pace) < 8 mm/s"
HOLD_NOSE = (
    "{kind: stalled, joints: [neck], loaded: [neck], share: 60 %, at_least: 50 mNm, "
    "settled: 1.5 s, still: 6 deg/s, for: 0.2 s}"
)
NEAR = """    near:
      forward: {wheel: left_fore, passed: -100 mm}
      backward: {wheel: right_hind, passed: -100 mm}
"""


@pytest.mark.parametrize("robot", [NEWT, PIRATE], ids=lambda path: path.name)
def test_a_shipped_robot_has_no_finding(robot: Path) -> None:
    assert check_robot(robot).findings == ()


def word(forward: str, backward: str) -> tuple[str, str]:
    """One more word after the newt's own."""
    return NEAR, f"{NEAR}    there:\n      forward: {{{forward}}}\n      backward: {{{backward}}}\n"


FAULTS = {
    "no state is asked for": (
        ("asks_for: Crawl == Ahead,", "asks_for: Crawl == Ahead and Crawl == Astern,"),
        "robot.asks_for", "Crawl == Ahead and",
    ),
    "every state is asked for": (
        ("asks_for: Crawl == Ahead,", "asks_for: Crawl in (Resting, Ahead, Astern),"
         .replace("asks_for: ", 'asks_for: "').replace("),", ')",')),
        "robot.asks_for", "Crawl in (Resting",
    ),
    "another state is asked for": (
        ("GoAhead: {asks_for: Crawl == Ahead", "GoAhead: {asks_for: Crawl == Astern"),
        "robot.asks_for", "Crawl == Astern",
    ),
    "a combination is asked for that is not reached": (
        ("GoAstern: {asks_for: Crawl == Astern",
         "GoAstern: {asks_for: Crawl == Astern and Grip == Loose"),
        "robot.asks_for", "Crawl == Astern and",
    ),
    "a signal is two things": (
        (STUCK, "abs(pace) < 8 mm/s and pace > 20 mm/s"), "robot.fault_never", "abs(pace)",
    ),
    "a signal is beyond its range": (
        (STUCK, "width_nose > 200 mm"), "robot.fault_never", "width_nose",
    ),
    "states that are never together": (
        (STUCK, "Grip == Loose and Crawl == Ahead"), "robot.fault_never", "Grip == Loose",
    ),
    "a size is not negative": (
        ("when: amps_a > 280 mA", "when: abs(amps_a) >= 0 mA"), "robot.fault_always", "abs(amps_a)",
    ),
    "anything is one or the other": (
        ("when: amps_a > 280 mA", "when: amps_a > 280 mA or amps_a < 300 mA"),
        "robot.fault_always", "amps_a > 280 mA or",
    ),
    "done after the timeout": (
        (HOLD_NOSE, HOLD_NOSE.replace("for: 0.2 s", "for: 9 s")), "robot.never_done", "9 s",
    ),
    "more torque than the motor gives": (
        (HOLD_NOSE, HOLD_NOSE.replace("50 mNm", "450 mNm")), "robot.never_done", "450 mNm",
    ),
    "more speed than the motor gives": (
        ("GoAhead: {asks_for: Crawl == Ahead, done: {kind: turning, share: 10 %}",
         "GoAhead: {asks_for: Crawl == Ahead, done: {kind: turning, share: 90 %}"),
        "robot.never_done", "90 %",
    ),
    "no wheel to turn": (
        (HOLD_NOSE, "{kind: turning, share: 20 %}"), "robot.never_done", "20 %",
    ),
    "longer on paper than it may take": (
        ("timeout: 2 s, nominal: 0.4 s", "timeout: 2 s, nominal: 3 s"), "robot.nominal", "3 s",
    ),
    "a clamp that takes longer on paper": (
        ("    timeout: 8 s\n    nominal: 2 s", "    timeout: 8 s\n    nominal: 10 s"),
        "robot.nominal", "10 s",
    ),
    "old before the next message": (
        ("stale_after: 300 ms", "stale_after: 20 ms"), "robot.link_times", "20 ms",
    ),
    "silent before its signals are old": (
        ("silent_after: 800 ms", "silent_after: 290 ms"), "robot.link_times", "290 ms",
    ),
    "steps as coarse as the duties": (
        ("duty_resolution: 0.5 %", "duty_resolution: 30 %"), "robot.setpoint", "30 %",
    ),
    "a command that lets go and does not say so": (
        ("    lets_go: true\n", ""), "robot.never_done", "Home:",
    ),
    "a board that sits nowhere": (
        ("module: rump\n    slots", "module: tail\n    slots"), "robot.reference", "tail",
    ),
    "two states that drive alike": (
        ("Astern: {drive_a: -80 %, drive_b: 80 %, drive_c: -80 %, drive_d: 80 %}",
         "Astern: {drive_a: 80 %, drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}"),
        "robot.reference", "Astern:",
    ),
    "silent before the next message": (
        ("silent_after: 800 ms", "silent_after: 25 ms"), "robot.link_times", "25 ms",
    ),
    "a loop without a choice": (
        ("least_duty: 15 %", "least_duty: 60 %"), "robot.position_loop", "60 %",
    ),
    "a loop below its least": (("limit: 50 %}", "limit: 10 %}"), "robot.position_loop", "15 %"),
    "an angle beyond the stop": (
        ("Loose: {fold_neck: 0 deg", "Loose: {fold_neck: 150 deg"), "robot.setpoint", "150 deg",
    ),
    "an angle below the stop": (
        ("fold_hip: 0 deg}", "fold_hip: -141 deg}"), "robot.setpoint", "-141 deg",
    ),
    "a word behind its like": (
        word("wheel: left_fore, passed: -100 mm", "wheel: right_hind, passed: 50 mm"),
        "robot.word_hidden", "{wheel: left_fore, passed: -100 mm}",
    ),
    "a word behind one that comes before it": (
        word("wheel: right_hind, passed: 50 mm", "wheel: right_hind, passed: -150 mm"),
        "robot.word_hidden", "{wheel: right_hind, passed: -100 mm}",
    ),
    "a safe state that lets go of the nose": (
        ("safe_state: {zero: [", "safe_state: {zero: [fold_neck, "),
        "robot.safe_clamp", "fold_neck",
    ),
    "a safe state that lets go of the tail": (
        ("drive_c, drive_d]}", "drive_c, drive_d, fold_hip]}"), "robot.safe_clamp", "fold_hip]",
    ),
    "a clamp that counts when it is accepted": (
        (HOLD_NOSE, "{kind: accepted}"), "robot.clamp_blind", "accepted}",
    ),
    "a clamp that the other part shows": (
        (HOLD_NOSE, HOLD_NOSE.replace("[neck]", "[hip]")), "robot.clamp_blind", "[hip], share",
    ),
    "a clamp to the other wall": (
        ("NoseHeld: {fold_neck: -50 %", "NoseHeld: {fold_neck: 50 %"), "robot.clamp_side", "50 %",
    ),
    "a clamp that changes its wall": (
        ("BothHeld: {fold_neck: -50 %, fold_hip: 50 %}",
         "BothHeld: {fold_neck: -50 %, fold_hip: -50 %}"),
        "robot.clamp_side", "-50 %}",
    ),
    "a clamp that nothing presses": (
        ("TailHeld: {fold_neck: 0 %, fold_hip: 50 %}", "TailHeld: {fold_neck: 0 %, fold_hip: 0 %}"),
        "robot.clamp_side", "0 %}",
    ),
    "sent again before it is confirmed": (
        ("resend_after: 100 ms", "resend_after: 10 ms"), "robot.link_times", "10 ms",
    ),
    "two channels of one name": (
        ("{name: wheel_d, signal", "{name: wheel_c, signal"), "robot.reference", "wheel_c, signal",
    ),
    "a wheel at the wall of its apex": (
        ("name: left_fore, part: nose, direction: 1", "name: left_fore, part: nose, direction: -1"),
        "robot.direction", "-1, mass",
    ),
    "another wheel at the wall of its apex": (
        ("part: tail, direction: -1", "part: tail, direction: 1"), "robot.direction", "1, mass",
    ),
    "a wheel against the others": (
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: -80 %"), "robot.wheels_fight", "-80 %",
    ),
    "a wheel that goes astern ahead": (
        ("drive_c: -80 %, drive_d: 80 %}", "drive_c: -80 %, drive_d: -80 %}"),
        "robot.wheels_fight", "-80 %}",
    ),
    "a wheel that does not mirror": (
        ("wheel: left_fore, mirrors: true", "wheel: left_fore"), "robot.mirrors", "drive_a",
    ),
    "a joint that does not mirror": (
        ("joint: hip, mirrors: true", "joint: hip, mirrors: false"), "robot.mirrors", "false}",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("swap", "code", "at"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_told_once_and_at_its_place(
    tmp_path: Path, swap: tuple[str, str], code: str, at: str
) -> None:
    check = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap))

    found = told(check.findings)

    assert [each for each, _ in found] == [code], found
    assert found[0][1].startswith(at)


@pytest.mark.parametrize(
    ("swap", "code", "at"),
    thorough_but([*FAULTS.values()][::4], FAULTS.values()),
    ids=FAULTS,
)
def test_only_rules_without_errors_are_left_out_before_a_run(
    tmp_path: Path, swap: tuple[str, str], code: str, at: str
) -> None:
    robot = changed(NEWT, tmp_path, "profile.yaml", swap)
    found = check_robot(robot).findings

    errors = [each for each in found if each.severity is Severity.ERROR]
    assert list(robot_errors(load_robot(robot))) == errors
    view = RobotView(load_robot(robot))
    rest = [each for rule in RULES if rule not in ERROR_RULES for each in rule(view)]
    assert all(each.severity is not Severity.ERROR for each in rest)


@pytest.mark.parametrize(
    ("first", "second", "held"),
    [("0 %", "-50 %", True), ("-50 %", "0 %", True), ("0 %", "0 %", False)],
    ids=["settles and presses", "keeps what its worm has wound", "never presses"],
)
def test_a_clamp_is_pressed_in_one_of_its_stages(
    tmp_path: Path, first: str, second: str, held: bool
) -> None:
    stages = f"[{{fold_neck: {first}, fold_hip: 0 %}}, {{fold_neck: {second}, fold_hip: 0 %}}]"
    swap = "NoseHeld: {fold_neck: -50 %, fold_hip: 0 %}", f"NoseHeld: {stages}"

    found = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings

    slack = [each for each in found if each.code == "robot.clamp_side"]
    assert len(slack) == (not held), found
    for each in slack:
        assert "nothing presses it to the wall" in each.message
        assert "negative value" in each.fix


@pytest.mark.parametrize(
    ("first", "breaks"),
    [
        ("{drive_a: 80 %, drive_b: 0 %, drive_c: 0 %, drive_d: 0 %}", True),
        ("{drive_a: 80 %, drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}", False),
    ],
    ids=["one wheel turns first", "all at once"],
)
def test_a_rule_may_be_broken_in_one_of_the_stages(
    tmp_path: Path, first: str, breaks: bool
) -> None:
    whole = "{drive_a: 80 %, drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}"
    stages = f"Ahead: [{first}, {whole}]" if breaks else f"Ahead: {first}"
    rule = "  - {rule: together, never: driven_wheels > 0 and driven_wheels < 4}\n"
    swaps = (f"Ahead: {whole}", stages), ("rules:\n", f"rules:\n{rule}")
    robot = changed(NEWT, tmp_path, "profile.yaml", *swaps)

    found = [each.code for each in check_robot(robot).findings]

    assert found.count("robot.rule_never") == (not breaks), found


def test_a_clamp_whose_sensor_is_not_fitted_is_never_done(tmp_path: Path) -> None:
    swaps = [
        (
            f"- {{name: {name}, signal: {signal}, convert: {convert}, "
            f"senses: {sense}, slot: fold_hip}}",
            "",
        )
        for name, signal, convert, sense in (
            ("hip", "hip", "fold_count", "angle"),
            ("hip_spring", "hip_torque", "spring_count", "torque"),
        )
    ]
    board = (
        "  - id: 5\n    module: rump\n    channels_fitted: false\n    slots: []\n    channels:\n"
    )
    board += "".join(f"      {line}\n" for line, _ in swaps)
    robot = changed(NEWT, tmp_path, "profile.yaml", *swaps, ("\nlink:\n", f"{board}\nlink:\n"))

    found = told(check_robot(robot).findings)
    never = [at for code, at in found if code == "robot.never_done"]  # HoldTail and Home

    assert Counter(code for code, _ in found) == {
        "robot.never_done": 2,
        "robot.seen_never": 2,
        "robot.reference": 1,
    }
    assert set(never) == {
        HOLD_NOSE.replace("neck", "hip").removeprefix("{kind: "),
        "below, signals: [neck, hip], limit: 6 deg, for: 0.2 s}",
    }


def test_a_fault_that_looks_for_a_broken_sensor_is_none(tmp_path: Path) -> None:
    swap = (STUCK, "neck > 145 deg")  # beyond the end stop

    assert check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings == ()


def test_a_rule_for_each_number_is_told_once(tmp_path: Path) -> None:
    robot = changed(
        PIRATE, tmp_path, "profile.yaml",
        ("when: bend_current_{i} > 0.93 * $gamma_{i}_stall_current",
         "when: bend_current_{i} > 0.93 * $gamma_{i}_stall_current and bend_current_{i} < 0 A"),
    )  # fmt: skip

    found = robot_findings(load_robot(robot))

    assert [each.code for each in found] == ["robot.fault_never"]
    assert found[0].severity is Severity.WARNING


def test_a_long_condition_is_told_at_its_first_line(tmp_path: Path) -> None:
    rest = "and BendingState in (FrontClampedRearRelaxed, DoubleClamped)"
    swap = (f"abs(gamma_1) > $gamma_1_stop - 2 deg {rest}", f"diameter_front > 140 mm {rest}")

    found = told(check_robot(changed(PIRATE, tmp_path, "profile.yaml", swap)).findings)

    assert found == [("robot.fault_never", swap[1])]


def test_every_finding_says_its_numbers(tmp_path: Path) -> None:
    swap = (HOLD_NOSE, HOLD_NOSE.replace("50 mNm", "450 mNm"))

    (found,) = check_robot(changed(NEWT, tmp_path, "profile.yaml", swap)).findings

    assert "at most 0.4 Nm" in found.message
    assert "0.45 Nm" in found.message


CONTROLS = "controls:\n"


def controlled(folder: Path, control: str) -> list[tuple[str, str]]:
    """What is said of a robot with one more control."""
    robot = changed(PIRATE, folder, "profile.yaml", (CONTROLS, f"{CONTROLS}{control}"))
    return told(check_robot(robot).findings)


SLOW = """\
  slow:
    actuation:
      FrontWheelsState:
        DrivingForward: {wheel_1: 5 mm/s, wheel_2: -5 mm/s, wheel_3: 5 mm/s}
      RearWheelsState:
        DrivingForward: {wheel_4: -5 mm/s, wheel_5: 5 mm/s, wheel_6: -5 mm/s}
  slow_too: {extends: slow, gravity_compensation: true}
"""


def test_a_command_that_is_never_done_under_a_control_is_told_there_once(tmp_path: Path) -> None:
    (found,) = controlled(tmp_path, SLOW)

    assert found == ("robot.never_done", "slow:")


def test_a_control_as_fast_as_the_criterion_asks_is_fine(tmp_path: Path) -> None:
    assert controlled(tmp_path, SLOW.replace("5 mm/s", "20 mm/s")) == []


WRONG_SIDE = """\
  across:
    actuation:
      BendingState:
        FrontClampedRearRelaxed: {bend_1: 350 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 0 mNm}
"""


def test_a_control_may_not_press_to_the_other_side_where_the_usual_duty_is_kept(
    tmp_path: Path,
) -> None:
    """The usual actuation leaves the apex as it is, so only the rule about sides sees it."""
    robot = changed(
        PIRATE, tmp_path, "profile.yaml",
        ("FrontClampedRearRelaxed: {bend_1: -70 %", "FrontClampedRearRelaxed: {bend_1: keep"),
        (CONTROLS, f"{CONTROLS}{WRONG_SIDE}"),
    )  # fmt: skip

    found = told(check_robot(robot).findings)

    assert [at for code, at in found if code == "robot.clamp_side"] == ["350 mNm, bend_2: 0 mNm, "
        "bend_3: 0 mNm, bend_4: 0 mNm}"]  # fmt: skip


def test_a_safe_state_may_not_let_go_of_what_only_a_control_presses(tmp_path: Path) -> None:
    robot = changed(
        PIRATE, tmp_path, "profile.yaml",
        ("FrontClampedRearRelaxed: {bend_1: -70 %", "FrontClampedRearRelaxed: {bend_1: keep"),
        (CONTROLS, f"{CONTROLS}{WRONG_SIDE.replace('350', '-350')}"),
        ("zero: [wheel_1", "zero: [bend_1, wheel_1"),
    )  # fmt: skip
    others = ("DoubleClamped", "FrontClampedRearBending", "FrontClampedRearBendingBack")
    profile = robot / "profile.yaml"
    text = profile.read_text(encoding="utf-8")
    for state in others:
        text = text.replace(f"{state}: {{bend_1: -70 %", f"{state}: {{bend_1: keep")
    text = text.replace("- {bend_1: -70 %", "- {bend_1: keep")
    text = text.replace("{bend_1: -350 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 350", "{bend_1: "
                        "keep, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 350")  # fmt: skip
    profile.write_text(text, encoding="utf-8")

    found = told(check_robot(robot).findings)

    assert ("robot.safe_clamp", "bend_1") in [(code, at[:6]) for code, at in found]
