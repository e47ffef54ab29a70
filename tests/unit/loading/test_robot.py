"""Every fault of a robot's profile is told, once, with the place that it stands at."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.loading.problems import LoadError
from pirate_sm.loading.robot import load_robot

ROOT = Path(__file__).resolve().parents[3]
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


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        # the body
        ("name: neck, wheel: right_fore", "name: neck, wheel: right",
         "22:27: there is no wheel 'right'"),
        ("name: neck, wheel: right_fore", "name: neck, wheel: left_fore",
         "22:27: 'left_fore' is an end of the chain: a joint is between two links"),
        ("left_fore, part: nose", "left_fore, part: nosey", "13:31: there is no part 'nosey'"),
        ("neck, wheel: right_fore, part: nose", "neck, wheel: right_fore, part: nos",
         "22:45: there is no part 'nos'"),
        ("name: right_fore, part", "name: left_fore, part", "14:14: 'left_fore' stands here twice"),
        ("direction: 1", "direction: 2", "13:48: expected one of 1, -1, got the number 2"),
        ("angle: roll_a", "angle: rol_a", "13:70: there is no signal 'rol_a'"),
        ("speed: spin_a", "speed: roll_a", "13:85: 'roll_a' is an angle"),
        ("mass: 15 g", "mass: -15 g", "13:57: expected more than 0 kg, got '-15 g'"),
        ("    - {module: rump, length: 80 mm, mass: 100 g}\n", "",
         "18:5: 4 wheels are joined by 3 links, got 2"),
        ("mass: 120 g}", "mass: 120 g, roll: twist}", "19:57: there is no signal 'twist'"),
        ("torque: neck_torque", "torque: neck_tork", "22:78: there is no signal 'neck_tork'"),
        ("torque: neck_torque", "torque: neck", "22:78: 'neck' is an angle"),
        ("apex: neck", "apex: nek", "25:18: there is no joint 'nek'"),
        ('"Grip in (NoseHeld, BothHeld)"', '"Grip in (NozeHeld, BothHeld)"',
         "25:40: 'Grip' is never 'NozeHeld'"),
        ('"Grip in (NoseHeld, BothHeld)"', "neck > 5 deg",
         "25:30: only states count here, not neck"),
        ('"Grip in (NoseHeld, BothHeld)"', '"Grip == Loose and Grip == NoseHeld"',
         "25:30: no configuration ever holds the part 'nose'"),
        # motors and slots
        ("    stiffness: 2 Nm/rad\n", "",
         "29:3: a motor of the kind sprung_worm needs `stiffness`"),
        ("stall_torque: 160 mNm", "stall_torque: 0 mNm",
         "38:19: `stall_torque` must be more than 0"),
        ("motor: bulb", "motor: bulp", "48:41: there is no motor 'bulp'"),
        ("{name: drive_b", "{name: drive_a", "56:16: 'drive_a' stands here twice"),
        ("wheel: right_fore, mirrors", "wheel: left_fore, mirrors",
         "56:58: 'left_fore' is driven by two slots"),
        ("motor: fold, joint: neck", "motor: fold, joint: neck, wheel: right_fore",
         "55:9: a slot drives one thing: joint, wheel or roll"),
        ("unit: duty, motor: track, wheel: left_fore",
         "unit: angle, motor: track, wheel: left_fore",
         "47:31: a slot for a wheel takes duty, not angle"),
        ("motor: bulb}", "motor: bulb, limit: 90 deg}", "48:54: only an angle has a limit"),
        ("joint: neck, mirrors", "joint: nek, mirrors", "55:59: the body has no joint 'nek'"),
        ("id: 3\n", "id: 40\n", "52:9: board 40 stands here twice"),
        ("id: 40", "id: forty", "44:9: expected a whole number, got the text 'forty'"),
        ("    module: head\n    slots", "    module: head\n    fitted: yes\n    slots",
         "46:13: expected true or false, got the text 'yes'"),
        ("    slots:\n      - {name: drive_a", "    slotz:\n      - {name: drive_a",
         "46:5: unknown key 'slotz'"),
        # channels
        ("senses: angle, slot: drive_a", "senses: angle, slot: drive_x",
         "50:82: there is no slot 'drive_x'"),
        ("senses: angle, slot: drive_a", "senses: angle",
         "50:69: whose angle is it? `slot` must say"),
        ("senses: angle, slot: drive_a", "senses: angle, slot: lamp",
         "50:82: 'lamp' drives nothing that could be measured"),
        ("senses: angle, slot: drive_a", "senses: torque, slot: drive_a",
         "50:83: only a joint's torque is measured, and 'drive_a' drives none"),
        ("senses: current", "senses: curent", "51:75: expected one of angle, torque, current"),
        ("convert: wheel_count, senses: angle, slot: drive_a",
         "convert: wheel_cont, senses: angle, slot: drive_a",
         "50:48: there is no conversion 'wheel_cont'"),
        ("signal: roll_b", "signal: roll_a", "59:31: 'roll_a' is told twice"),
        ("signal: amps_a", "signal: mm",
         "51:39: 'mm' cannot be the name of a signal: it is a unit"),
        ("signal: amps_a", "signal: detector", "51:39: 'detector' is told twice"),
        # conversions and derived signals
        ("{scale: 1 rev / 2000}", "{scale: 1 mm / 2000}", "13:70: 'roll_a' is a length"),
        ("{scale: 1 rev / 2000}", "{scale: 1 / 2000}", "13:70: 'roll_a' is a bare number"),
        ("{scale: 1 rev / 2000}", "{scale: 1 rev / 0}", "84:24: expected a number with a unit"),
        ("{scale: 1 rev / 2000}", "{scale: neck}", "84:24: unknown name 'neck'"),
        ("{rate_of: roll_a}", "{rate_of: roll_x}", "90:11: 'roll_x' is not known here"),
        ("{rate_of: roll_a}", "{rat_of: roll_a}", "90:3: expected a mapping with one of rate_of"),
        ("spin_a: {rate", "in: {rate", "90:3: 'in' cannot be the name of a signal"),
        ("diameter_of: nose", "diameter_of: noes", "96:15: 'noes' is not known here"),
        ("odometry_of: [left_fore", "odometry_of: [left", "98:8: 'left' is not known here"),
        # actuation
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_x: 80 %", "109:22: there is no slot 'drive_x'"),
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 180 %", "109:22: a duty cycle lies between"),
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 0.8", "109:22: expected a duty cycle such as"),
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 80 deg",
         "109:22: 'drive_a' takes a duty cycle: its motor has no position loop to hold an angle"),
        ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 80 mm",
         "109:22: expected a duty cycle such as"),
        ("Lit: {lamp: 60 %}", "Lit: {}", "113:10: other states of Lamp write lamp"),
        ("  Lamp:\n    Dark: {lamp: 0 %}\n    Lit: {lamp: 60 %}\n", "",
         "101:1: region 'Lamp' is missing here"),
        ("    Lit: {lamp: 60 %}\n", "", "111:3: Lamp.Lit is missing here"),
        ("    Lit: {lamp", "    Lot: {lamp", "113:5: Lamp has no state 'Lot'"),
        ("  Lamp:\n    Dark", "  Lamb:\n    Dark", "111:3: the chart has no region 'Lamb'"),
        # commands
        ("asks_for: Crawl == Ahead", "asks_for: Crawl == Ahed", "128:32: 'Crawl' is never 'Ahed'"),
        ("kind: turning", "kind: turing", "128:52: expected one of accepted, stalled, reached"),
        ("joints: [neck], loaded", "joints: [nec], loaded",
         "118:36: whether 'nec' stands still needs a derived signal {rate_of: nec}"),
        ("loaded: [neck]", "loaded: [nec]", "118:52: 'nec' is no joint with a torque signal"),
        ("signals: [neck, hip]", "signals: [neck, hop]", "134:41: there is no signal 'hop'"),
        ("limit: 6 deg", "limit: 6 mm", "134:54: 'neck' is an angle"),
        ("timeout: 8 s", "timeout: 0 s", "119:14: expected more than 0 s, got '0 s'"),
        ("  Rest: {asks", "  Rast: {asks", "130:3: the chart has no event 'Rast'"),
        ("  Rest: {asks", "  Rast: {asks", "115:1: the chart's event 'Rest' is missing here"),
        ("aliases: {Stop: Rest}", "aliases: {Stop: Rast}", "138:17: there is no command 'Rast'"),
        ("aliases: {Stop: Rest}", "aliases: {Home: Rest}", "138:11: 'Home' is a command"),
        # safety
        ("zero: [drive_a, ", "zero: [drive_x, drive_a, ", "142:21: there is no slot 'drive_x'"),
        ("zero: [drive_a, ", "zero: [",
         "142:20: 'drive_a' drives a wheel: it must be zero in the safe state"),
        ("abs(pace) < 8 mm/s", "abs(pase) < 8 mm/s", "146:44: unknown name 'pase'"),
        ("abs(pace) < 8 mm/s", "abs(pace) < 8", "146:52: '8' needs a unit here"),
        ("held: 2 s", "held: -2 s", "147:11: expected at least 0 s, got '-2 s'"),
        ("code: robot.stuck", "code: stuck", "145:11: the text 'stuck' does not fit"),
        ("code: motor.hot", "code: link.lost", "149:11: 'link.lost' cannot be caught"),
        # detector and simulation
        ("forward: {wheel: left_fore", "forward: {wheel: left", "158:24: there is no wheel 'left'"),
        ("    near:\n", "    and:\n", "157:5: 'and', a word of 'detector', cannot be used"),
        ("wheels: [left_hind]", "wheels: [left]", "165:116: there is no wheel 'left'"),
        ("kind: dead_wheel", "kind: dead", "165:29: expected one of dead_wheel, stiff_joint"),
        (", wheels: [left_hind]}", "}", "165:5: a dead_wheel needs `wheels`"),
        (", wheels: [left_hind]}", ", wheels: [left_hind], raw: {rol_a: 5}}",
         "165:134: there is no measured signal 'rol_a'"),
        ("kinetic: 0.6", "kinetic: 0.9", "162:3: kinetic friction cannot be more than static"),
        # the file
        ("robot: newt\n", "robot: newt\nrobot: newt\n", "5:1: the key 'robot' stands twice"),
        ("chart: chart.yaml", "chart: chartt.yaml", "6:8: chartt.yaml: there is no such file"),
        ("chart: chart.yaml", "chart: .", "6:8: "),
        ("format: 1", "format: 2", "3:9: expected 1, got the number 2"),
        ("resend_limit: 4", "resend_limit: true", "81:17: expected a whole number, got true"),
        ("cycle: 10 ms", "cycle: 10", "74:10: expected a duration such as '2 s', got '10' without"),
    ],
)  # fmt: skip
def test_a_fault_of_the_profile_is_told_with_its_place(newt, old, new, fault):
    said = newt("profile.yaml", (old, new))

    assert any(each.startswith(f"profile.yaml:{fault}") for each in said), said


def test_two_regions_do_not_write_one_slot(newt):
    said = newt(
        "profile.yaml",
        ("Dark: {lamp: 0 %}", "Dark: {drive_a: 0 %}"),
        ("Lit: {lamp: 60 %}", "Lit: {drive_a: 5 %}"),
    )

    assert said == ["profile.yaml:112:5: 'drive_a' is written by Crawl too"]


def test_one_code_is_caught_or_not_whoever_raises_it(newt):
    twice = "  - code: robot.stuck\n    when: Lamp == Lit\n    held: 1 s\n    message: x\n"

    said = newt("profile.yaml", ("faults:\n", f"faults:\n{twice}    catchable: false\n"))

    assert said == [
        "profile.yaml:150:11: 'robot.stuck' cannot be caught: `catchable` must be false here too"
    ]


def test_all_faults_at_once(newt):
    said = newt(
        "profile.yaml",
        ("name: neck, wheel: right_fore", "name: neck, wheel: right"),
        ("senses: angle, slot: drive_a", "senses: angle, slot: drive_x"),
        ("wheels: [left_hind]", "wheels: [left]"),
        ("  Rest: {asks", "  Rast: {asks"),
    )

    places = [each.split(": ")[0].removeprefix("profile.yaml:") for each in said]
    assert places == ["22:27", "50:82", "115:1", "130:3", "138:17", "165:116"]


def test_a_robot_without_slots_is_refused(newt):
    text = (NEWT / "profile.yaml").read_text("utf-8")
    slots = [line for line in text.splitlines() if ", unit: duty, motor: " in line]
    swaps = [(f"{line}\n", "") for line in slots]

    said = newt("profile.yaml", *swaps, *[("    slots:\n", "    slots: []\n")] * 3)

    assert said[0] == "profile.yaml:44:3: no board has a slot"


@pytest.mark.parametrize("missing", ["profile.yaml", "chart.yaml"])
def test_a_missing_file_is_told(newt, tmp_path, missing):
    assert newt("profile.yaml") == []
    (tmp_path / "newt" / missing).unlink()
    load_robot.cache_clear()

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
