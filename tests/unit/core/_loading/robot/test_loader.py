"""Every fault of a robot's profile is told, once, with the place that it stands at."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.robot.loader import load_robot

from .broken_profiles import FAULTS, GRIP_FAULTS, TRACTION_FAULTS

ROOT = Path(__file__).resolve().parents[5]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"


@pytest.mark.parametrize("folder", [PIRATE, NEWT], ids=lambda path: path.name)
def test_a_robot_loads_in_both_polarities(folder):
    robot = load_robot(folder)

    assert robot.oriented("normal").polarity == "normal"
    assert robot.oriented("mirrored").polarity == "mirrored"
    assert robot.normal.vocabulary.types == robot.mirrored.vocabulary.types


def test_mirrored_polarity_turns_what_mirrors_and_nothing_else():
    robot = load_robot(PIRATE)
    mirrors = {slot.name: slot.mirrors for slot in robot.profile.slots}
    for normal, mirrored in zip(robot.normal.actuation, robot.mirrored.actuation, strict=True):
        for state, stages in normal.items():
            for one, other in zip(stages, mirrored[state], strict=True):
                for write, turned in zip(one, other, strict=True):
                    sign = -1 if mirrors[robot.normal.slots[write.slot].name] else 1
                    assert turned.value == sign * write.value
                    assert (turned.slot, turned.how) == (write.slot, write.how)


def test_each_part_is_held_where_the_decisions_say():
    robot = load_robot(PIRATE).normal
    bending = robot.regions.index("BendingState")
    held = {
        states[bending]: {robot.parts[part] for part in parts}
        for states, parts in zip(robot.table.configurations, robot.held, strict=True)
    }

    assert held == {
        "Unclamped": set(),
        "DoubleClamped": {"front", "rear"},
        "FrontClampedRearRelaxed": {"front"},
        "FrontClampedRearBending": {"front"},
        "FrontClampedRearBendingBack": {"front"},
        "RearClampedFrontRelaxed": {"rear"},
        "RearClampedFrontBending": {"rear"},
        "RearClampedFrontBendingBack": {"rear"},
    }


@pytest.mark.parametrize(("old", "new", "at", "message"), [*FAULTS, *TRACTION_FAULTS])
def test_a_fault_of_the_profile_is_told_with_its_place(newt, tmp_path, old, new, at, message):
    _is_told(newt, tmp_path, [(old, new)], at, message)


@pytest.mark.parametrize(("swaps", "at", "message"), GRIP_FAULTS)
def test_a_fault_of_a_control_is_told_with_its_place(newt, tmp_path, swaps, at, message):
    _is_told(newt, tmp_path, swaps, at, message)


def _is_told(newt, tmp_path, swaps, at, message):
    said = [parts(each) for each in newt("profile.yaml", *swaps)]

    found = [place for place, text in said if text.startswith(message)]
    assert found, said
    file, line, column = found[0].split(":")
    written = (tmp_path / "newt" / file).read_text("utf-8").splitlines()[int(line) - 1]
    assert written[int(column) - 1 :].startswith(at)


def parts(fault: str) -> tuple[str, str]:
    """The place and the message of a fault."""
    place, _, message = fault.partition(": ")
    return place, message


BEARING = (
    "least_duty: 15 %, limit: 50 %}\n",
    "least_duty: 15 %, limit: 50 %}\n"
    "    torque_loop: {gain: 1.2, dead: 30 mNm, within: 40 mNm, limit: 70 %}\n",
)
"""A `torque_loop` for the folds of the small robot."""


@pytest.mark.parametrize(
    ("setpoint", "swaps", "message"),
    [
        (
            "-300 mNm",
            [("end_stop: 130 deg, torque: neck_torque}", "end_stop: 130 deg}")],
            "'fold_neck' cannot be kept at a torque: that takes a joint with a torque sensor",
        ),
        (
            "-600 mNm",
            [],
            "600 mNm is more than 'fold_neck' can bear at its limit, 560 mNm",
        ),
    ],
)
def test_a_torque_that_cannot_be_kept_is_told_with_its_place(
    newt, tmp_path, setpoint, swaps, message
):
    held = "NoseHeld: {fold_neck: -50 %, fold_hip: 0 %}"
    bearing = (held, held.replace("-50 %", setpoint))

    said = [parts(each) for each in newt("profile.yaml", BEARING, bearing, *swaps)]

    (place,) = [place for place, text in said if text.startswith(message)]
    file, line, column = place.split(":")
    written = (tmp_path / "newt" / file).read_text("utf-8").splitlines()[int(line) - 1]
    assert written[int(column) - 1 :].startswith(setpoint)


def test_a_speed_in_a_control_that_the_motor_never_reaches_is_reported(newt):
    said = newt(
        "profile.yaml",
        ("    dead_drag: 30 mNm\n", "    dead_drag: 30 mNm\n    velocity_loop: {gain: 0.3}\n"),
        (
            "aliases: {",
            "controls:\n  fast:\n    actuation:\n      Crawl:\n        Ahead: {drive_a: 120 mm/s,"
            " drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}\naliases: {",
        ),
    )

    assert [parts(each)[1] for each in said] == [
        "120 mm/s is more than 'drive_a' reaches, 100 mm/s"
    ]


def test_a_control_changes_the_states_that_it_names_and_no_others():
    robot = load_robot(PIRATE).normal
    (control,) = [each for each in robot.controls if each.name == "exp_3a"]
    usual = robot.controls[0]
    changed = {
        (robot.regions[region], state)
        for region, states in enumerate(usual.actuation)
        for state, stages in states.items()
        if control.actuation[region][state] != stages
    }

    assert usual.name == ""
    assert usual.actuation == robot.actuation
    assert changed == {
        ("FrontWheelsState", "DrivingForward"),
        ("FrontWheelsState", "DrivingBackward"),
        ("RearWheelsState", "DrivingForward"),
        ("RearWheelsState", "DrivingBackward"),
        ("BendingState", "DoubleClamped"),
    }


def test_two_regions_do_not_write_one_slot(newt):
    said = newt(
        "profile.yaml",
        ("Dark: {lamp: 0 %}", "Dark: {drive_a: 0 %}"),
        ("Lit: {lamp: 60 %}", "Lit: {drive_a: 5 %}"),
    )

    assert [parts(each)[1] for each in said] == ["'drive_a' is written by Crawl too"]


def test_one_code_is_caught_or_not_whoever_raises_it(newt):
    twice = "  - code: robot.stuck\n    when: Lamp == Lit\n    held: 1 s\n    message: x\n"

    said = newt("profile.yaml", ("faults:\n", f"faults:\n{twice}    catchable: false\n"))

    assert [parts(each)[1] for each in said] == [
        "'robot.stuck' cannot be caught: `catchable` must be false here too"
    ]


def test_all_faults_at_once(newt):
    said = newt(
        "profile.yaml",
        ("name: neck, wheel: right_fore", "name: neck, wheel: right"),
        ("senses: angle, slot: drive_a", "senses: angle, slot: drive_x"),
        ("wheels: [left_hind]", "wheels: [left]"),
        ("  Rest: {asks", "  Rast: {asks"),
    )

    assert [parts(each)[1] for each in said] == [
        "there is no wheel 'right'",
        "there is no slot 'drive_x'",
        "the chart's event 'Rest' is missing here",
        "the chart has no event 'Rast'",
        "there is no command 'Rest'",
        "there is no wheel 'left'",
    ]


def test_a_robot_without_slots_is_refused(newt):
    text = (NEWT / "profile.yaml").read_text("utf-8")
    slots = [line for line in text.splitlines() if ", unit: duty, motor: " in line]
    swaps = [(f"{line}\n", "") for line in slots]

    said = newt("profile.yaml", *swaps, *[("    slots:\n", "    slots: []\n")] * 3)

    assert parts(said[0])[1] == "no board has a slot"


@pytest.mark.parametrize("missing", ["profile.yaml", "chart.yaml"])
def test_a_missing_file_is_reported(newt, tmp_path, missing):
    assert newt("profile.yaml") == []
    (tmp_path / "newt" / missing).unlink()

    with pytest.raises(LoadError, match="there is no such file"):
        load_robot(tmp_path / "newt")


def test_a_board_that_is_not_fitted_leaves_its_signals_unknown(newt, tmp_path):
    assert (
        newt("profile.yaml", ("    module: head\n", "    module: head\n    fitted: false\n")) == []
    )
    robot = load_robot(tmp_path / "newt").normal

    assert 40 not in robot.boards
    assert "roll_a" in robot.vocabulary.numbers
    assert len(robot.slots) == 7, "its place on the wire stays"


@pytest.mark.parametrize(("stop_deg", "angle_deg", "lost"), [
    (130, 127.9, False), (130, 128.1, True), (130, -128.1, True), (110, 108.1, True),
])  # fmt: skip
def test_a_fault_rule_follows_the_end_stop_of_a_joint(loaded_newt, stop_deg, angle_deg, lost):
    robot = loaded_newt(
        "profile.yaml",
        ("end_stop: 130 deg", f"end_stop: {stop_deg} deg"),
        ("when: amps_a > 280 mA", "when: abs(neck) > $neck_stop - 2 deg"),
    ).normal  # fmt: skip
    rule = next(fault for fault in robot.faults if fault.code == "motor.hot")
    numbers = [math.nan] * len(robot.vocabulary.numbers)
    numbers[robot.vocabulary.numbers.index("neck")] = math.radians(angle_deg)
    words = [None] * len(robot.vocabulary.words)
    assert rule.when.evaluate(numbers, words) is lost


def test_a_fault_rule_with_the_end_stop_of_no_joint_is_reported(newt):
    old, new = "when: amps_a > 280 mA", "when: abs(neck) > $nek_stop"
    (line,) = (
        number
        for number, text in enumerate((NEWT / "profile.yaml").read_text("utf-8").splitlines(), 1)
        if old in text
    )

    said = newt("profile.yaml", (old, new))

    assert said == [f"profile.yaml:{line}:23: there is no parameter '$nek_stop'"]
