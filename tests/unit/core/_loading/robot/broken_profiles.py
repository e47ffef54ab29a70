"""What can be wrong with a profile: what stands in the small robot's, what is put in its place,
the text at which the fault is shown, and how its message begins.
"""

from __future__ import annotations

_BACKWARD = "      backward: {wheel: right_hind, passed: -100 mm}\n"
_POINTS = "      forward: {wheel: left_fore, passed: -100 mm}\n" + _BACKWARD
_BEFORE = "actuation:\n  Grip:\n"
_CASE = "postures: {bowed: [{when: Grip == NoseHeld, set: {fold_neck: -50 %, fold_hip: 10 deg}}]}\n"


def _posture(old: str, new: str) -> tuple[str, str]:
    """Puts in a posture in which something stands instead of what is right."""
    assert old in _CASE
    return _BEFORE, _CASE.replace(old, new) + _BEFORE


_TORQUE = "    position_loop: {gain: 3.0, threshold: 3 deg, least_duty: 15 %, limit: 50 %}\n"
_BEARS = "torque_loop: {gain: 1.2, dead: 30 mNm, within: 40 mNm, limit: 70 %}"
_CONTROLS = """controls:
  first:
    actuation: {Crawl: {Ahead: {drive_a: 60 %, drive_b: -60 %, drive_c: 60 %, drive_d: -60 %}}}
  second: {extends: first, actuation: {Grip: {TailHeld: {fold_neck: 0 %, fold_hip: 40 %}}}}
"""


def _control(old: str, new: str) -> tuple[str, str]:
    """Puts in controls in which something stands instead of what is right."""
    assert old in _CONTROLS
    return "aliases: {", _CONTROLS.replace(old, new) + "aliases: {"


FAULTS = [
    (
        _TORQUE,
        "    torque_loop: {gain: 1.2, dead: 40 mNm, within: 30 mNm}\n",
        "torque_loop: {gain: 1.2, dead",
        "`within` must be at least `dead`: the motor stands inside of that",
    ),
    (
        _TORQUE,
        "    torque_loop: {gain: 1.2, dead: 30 mNm, within: 40 mN}\n",
        "40 mN}",
        "expected a torque such as",
    ),
    (
        _TORQUE,
        "    torque_loop: {gain: 0, dead: 30 mNm, within: 40 mNm}\n",
        "0, dead",
        "expected more than 0, got",
    ),
    (
        "    no_load_speed: 5 rad/s\n",
        f"    no_load_speed: 5 rad/s\n    {_BEARS}\n",
        "track:",
        "a `torque_loop` needs `kind: sprung_worm` and the `stall_torque`",
    ),
    (
        "NoseHeld: {fold_neck: -50 %, fold_hip: 0 %}",
        "NoseHeld: {fold_neck: -300 mNm, fold_hip: 0 %}",
        "-300 mNm",
        "'fold_neck' cannot be kept at a torque: that takes a joint with a torque sensor",
    ),
    (
        "Lit: {lamp: 60 %}",
        "Lit: {lamp: 6 mNm}",
        "6 mNm",
        "'lamp' cannot be kept at a torque",
    ),
    (
        "Ahead: {drive_a: 80 %",
        "Ahead: {drive_a: 161 mNm",
        "161 mNm",
        "161 mNm is more than 'drive_a' can bear at its limit, 160 mNm",
    ),
    (
        *_control("drive_d: -60 %", "drive_d: -170 mNm"),
        "-170 mNm",
        "170 mNm is more than 'drive_d' can bear at its limit, 160 mNm",
    ),
    (
        *_control("drive_d: -60 %", "drive_d: -60 mm/s"),
        "-60 mm/s",
        "'drive_d' has no wheel whose motor has a velocity loop to keep a speed",
    ),
    (*_control("fold_hip: 40 %", "fold_hip: 140 %"), "140 %", "a duty cycle lies between"),
    (*_control("    actuation: {Crawl", "    acts: {Crawl"), "acts", "unknown key 'acts'"),
    (*_control("extends: first", "extends: firts"), "firts", "there is no control before this one"),
    (*_control("extends: first", "extends: second"), "second", "there is no control before this"),
    (
        *_control("first:\n", "first:\n    extends: second\n"),
        "second",
        "there is no control before",
    ),
    (
        *_control("drive_a: 60 %", "drive_a: -60 %"),
        "-60 %, drive_b",
        "'drive_a' turns the other way than under `actuation`",
    ),
    (
        *_control("fold_hip: 40 %", "fold_hip: -40 %"),
        "-40 %}",
        "'fold_hip' turns the other way than under `actuation`",
    ),
    (
        *_control("fold_hip: 40 %", "fold_hip: 0 %"),
        "0 %}}}}",
        "'fold_hip' holds its part under `actuation`, here it lets go",
    ),
    (*_control("second:", "none:"), "none:", "'none' is how a mission asks for the default"),
    (
        _TORQUE,
        "    torque_loop: {gain: 1, dead: 1 mNm, within: 1 mNm, least_duty: 50 %, limit: 40 %}\n",
        "torque_loop: {gain",
        "`least_duty` is more than `limit`: the worm would never move",
    ),
    (*_control("Crawl", "Crawls"), "Crawls:", "there is no region 'Crawls'"),
    (*_control("Ahead", "Ahed"), "Ahed:", "there is no state 'Ahed'"),
    (
        *_control("fold_hip: 40 %", "fold_hip: 40 deg"),
        "40 deg",
        "a control takes duty cycles, speeds and torques, no angles",
    ),
    (
        *_control("fold_hip: 40 %", "fold_hip: 0.5 * neck"),
        "0.5 * neck",
        "a control takes duty cycles, speeds and torques, no angles",
    ),
    (*_control("fold_hip: 40 %", "fold_hop: 40 %"), "40 %", "there is no slot 'fold_hop'"),
    (
        *_control("fold_neck: 0 %, ", ""),
        "{fold_hip",
        "write the same slots as `actuation`, not fold_neck",
    ),
    (
        *_control("fold_neck: 0 %", "fold_neck: 0 %, lamp: 0 %"),
        "{fold_neck",
        "write the same slots as `actuation`, not lamp",
    ),
    (
        *_control("drive_d: -60 %", "drive_d: 0 %"),
        "{drive_a: 60 %",
        "drive the same wheels as `actuation` does: drive_d",
    ),
    (
        *_control(
            "{fold_neck: 0 %, fold_hip: 40 %}",
            "[{fold_neck: 0 %, fold_hip: 40 %}, {fold_neck: 0 %, fold_hip: 30 %}]",
        ),
        "[{fold_neck",
        "the state has 1 stages, under this control 2",
    ),
    (
        *_posture("fold_hip: 10 deg", "drive_a: 0 %"),
        "drive_a: 0 %",
        "'drive_a' drives no bend joint, and a posture moves only those",
    ),
    (
        *_posture("fold_neck: -50 %", "fold_neck: 0 %"),
        "{fold_neck",
        "'fold_neck' holds the part 'nose' there: it must keep a duty of that sign",
    ),
    (
        *_posture("fold_neck: -50 %", "fold_neck: 50 %"),
        "{fold_neck",
        "'fold_neck' holds the part 'nose' there",
    ),
    (
        *_posture("fold_neck: -50 %", "fold_neck: 0.5 * hip"),
        "{fold_neck",
        "'fold_neck' holds the part 'nose' there",
    ),
    (*_posture("10 deg", "0.5 * nek"), "0.5 * nek", "there is no joint 'nek'"),
    (*_posture("Grip == NoseHeld", "neck > 5 deg"), "neck > 5", "only states count here"),
    (
        *_posture("set: {fold_neck: -50 %, fold_hip: 10 deg}", "within: 5 deg"),
        "{when",
        "expected exactly one of `set` and `refuse`",
    ),
    (
        *_posture("set: {fold_neck: -50 %, fold_hip: 10 deg}", "refuse: no, within: 5 deg"),
        "{when",
        "`within` and `done` go with `set`: what is refused is never done",
    ),
    (
        "NoseHeld: {fold_neck: -50 %, fold_hip: 0 %}",
        "NoseHeld: {fold_neck: -50 %, fold_hip: 0.5 * neck}",
        "0.5 * neck",
        "a share of a joint's angle is for postures: in a state it could be unknown",
    ),
    (
        "  HoldNose:\n    asks_for",
        "  HoldNose:\n    posture: bowed\n    asks_for",
        "bowed",
        "there is no posture 'bowed'",
    ),
    (
        "name: neck, wheel: right_fore",
        "name: neck, wheel: right",
        "right",
        "there is no wheel 'right'",
    ),
    (
        "name: neck, wheel: right_fore",
        "name: neck, wheel: left_fore",
        "left_fore",
        "'left_fore' is an end of the chain: a joint is between two links",
    ),
    ("left_fore, part: nose", "left_fore, part: nosey", "nosey", "there is no part 'nosey'"),
    (
        "neck, wheel: right_fore, part: nose",
        "neck, wheel: right_fore, part: nos",
        "nos",
        "there is no part 'nos'",
    ),
    (
        "name: right_fore, part",
        "name: left_fore, part",
        "left_fore",
        "'left_fore' is listed twice",
    ),
    (
        "direction: 1",
        "direction: 2",
        "2, mass: 15 g, angle: ro",
        "expected one of 1, -1, got the number 2",
    ),
    ("angle: roll_a", "angle: rol_a", "rol_a", "there is no signal 'rol_a'"),
    ("speed: spin_a", "speed: roll_a", "roll_a", "'roll_a' is an angle"),
    ("mass: 15 g", "mass: -15 g", "-15 g", "expected more than 0 g, got '-15 g'"),
    (
        "    - {module: rump, length: 80 mm, mass: 100 g}\n",
        "",
        "links:",
        "4 wheels are joined by 3 links, got 2",
    ),
    ("mass: 120 g}", "mass: 120 g, roll: twist}", "twist", "there is no signal 'twist'"),
    ("torque: neck_torque", "torque: neck_tork", "neck_tork", "there is no signal 'neck_tork'"),
    ("torque: neck_torque", "torque: neck", "neck", "'neck' is an angle"),
    ("apex: neck", "apex: nek", "nek", "there is no joint 'nek'"),
    (
        '"Grip in (NoseHeld, BothHeld)"',
        '"Grip in (NozeHeld, BothHeld)"',
        "NozeHeld",
        "'Grip' is never 'NozeHeld'",
    ),
    (
        '"Grip in (NoseHeld, BothHeld)"',
        "neck > 5 deg",
        "neck > 5 deg",
        "only states count here, not neck",
    ),
    (
        '"Grip in (NoseHeld, BothHeld)"',
        '"Grip == Loose and Grip == NoseHeld"',
        '"Grip == Loose and Grip',
        "no configuration ever holds the part 'nose'",
    ),
    (
        "    stiffness: 2 Nm/rad\n",
        "",
        "fold:",
        "a motor of the kind sprung_worm needs `stiffness`",
    ),
    (
        "stall_torque: 160 mNm",
        "stall_torque: 0 mNm",
        "0 mNm",
        "`stall_torque` must be more than 0",
    ),
    ("    hold_torque: 160 mNm\n", "", "track:", "a motor of the kind geared needs `hold_torque`"),
    ("    dead_drag: 30 mNm\n", "", "track:", "a motor of the kind geared needs `dead_drag`"),
    ("motor: bulb", "motor: bulp", "bulp", "there is no motor 'bulp'"),
    ("motor: track, wheel", "motor: tracks, wheel", "tracks", "there is no motor 'tracks'"),
    ("motor: fold, joint", "motor: folds, joint", "folds", "there is no motor 'folds'"),
    ("{name: drive_b", "{name: drive_a", "drive_a", "'drive_a' is listed twice"),
    (
        "wheel: right_fore, mirrors",
        "wheel: left_fore, mirrors",
        "left_fore",
        "'left_fore' is driven by two slots",
    ),
    (
        "motor: fold, joint: neck",
        "motor: fold, joint: neck, wheel: right_fore",
        "{name: fold_neck",
        "a slot drives one thing: joint, wheel or roll",
    ),
    (
        "unit: duty, motor: track, wheel: left_fore",
        "unit: angle, motor: track, wheel: left_fore",
        "angle",
        "a slot for a wheel takes duty, not angle",
    ),
    ("motor: bulb}", "motor: bulb, limit: 90 deg}", "90 deg", "only an angle has a limit"),
    ("joint: neck, mirrors", "joint: nek, mirrors", "nek", "the body has no joint 'nek'"),
    ("id: 3\n", "id: 40\n", "40", "board 40 is listed twice"),
    ("id: 40", "id: forty", "forty", "expected a whole number, got the text 'forty'"),
    (
        "    module: head\n    slots",
        "    module: head\n    fitted: yes\n    slots",
        "yes",
        "expected true or false, got the text 'yes'",
    ),
    (
        "    slots:\n      - {name: drive_a",
        "    slotz:\n      - {name: drive_a",
        "slotz:",
        "unknown key 'slotz'",
    ),
    (
        "senses: angle, slot: drive_a",
        "senses: angle, slot: drive_x",
        "drive_x",
        "there is no slot 'drive_x'",
    ),
    (
        "senses: angle, slot: drive_a",
        "senses: angle",
        "angle",
        "`slot` must say whose angle this is",
    ),
    (
        "senses: angle, slot: drive_a",
        "senses: angle, slot: lamp",
        "lamp",
        "'lamp' drives nothing that could be measured",
    ),
    (
        "senses: angle, slot: drive_a",
        "senses: torque, slot: drive_a",
        "drive_a",
        "only a joint's torque is measured, and 'drive_a' drives none",
    ),
    ("senses: current", "senses: curent", "curent", "expected one of angle, torque, current"),
    (
        "convert: wheel_count, senses: angle, slot: drive_a",
        "convert: wheel_cont, senses: angle, slot: drive_a",
        "wheel_cont",
        "there is no conversion 'wheel_cont'",
    ),
    ("signal: roll_b", "signal: roll_a", "roll_a", "'roll_a' is declared twice"),
    ("signal: amps_a", "signal: mm", "mm", "'mm' cannot be the name of a signal: it is a unit"),
    ("signal: amps_a", "signal: detector", "detector", "'detector' is declared twice"),
    ("{scale: 1 rev / 2000}", "{scale: 1 mm / 2000}", "roll_a", "'roll_a' is a length"),
    ("{scale: 1 rev / 2000}", "{scale: 1 / 2000}", "roll_a", "'roll_a' is a bare number"),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 1 rev / 0}",
        "1 rev / 0",
        "'1 rev / 0' divides by zero",
    ),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 1 rev / (2 - 2)}",
        "1 rev / (2",
        "'1 rev / (2 - 2)' divides by zero",
    ),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 0 rev}",
        "0 rev}",
        "'0 rev' is zero: every count would mean the same",
    ),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 1e-300 rev / 1e100}",
        "1e-300",
        "'1e-300 rev / 1e100' is zero",
    ),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 1e-310 rev}",
        "1e-310",
        "'1e-310 rev' is too large or too small",
    ),
    (
        "{scale: 1 rev / 2000}",
        "{scale: 2000 > 1}",
        "2000 > 1",
        "expected a number with a unit",
    ),
    ("{scale: 1 rev / 2000}", "{scale: neck}", "neck", "unknown name 'neck'"),
    (
        "{rate_of: roll_a}",
        "{rate_of: roll_x}",
        "{rate_of: roll_x",
        "'roll_x' is not known here",
    ),
    (
        "{rate_of: roll_a}",
        "{rat_of: roll_a}",
        "rat_of: roll_a",
        "expected a mapping with one of rate_of",
    ),
    (
        "spin_a: {rate",
        "in: {rate",
        "in: {rate_of: roll_a",
        "'in' cannot be the name of a signal",
    ),
    (
        "diameter_of: nose",
        "diameter_of: noes",
        "{diameter_of: noes",
        "'noes' is not known here",
    ),
    (
        "odometry_of: [left_fore",
        "odometry_of: [left",
        "{odometry_of: [left",
        "'left' is not known here",
    ),
    ("Ahead: {drive_a: 80 %", "Ahead: {drive_x: 80 %", "80 %", "there is no slot 'drive_x'"),
    ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 180 %", "180 %", "a duty cycle lies between"),
    ("Ahead: {drive_a: 80 %", "Ahead: {drive_a: 0.8", "0.8", "expected a duty cycle such as"),
    (
        "Ahead: {drive_a: 80 %",
        "Ahead: {drive_a: 80 deg",
        "80 deg",
        "'drive_a' takes a duty cycle: its motor has no position loop to hold an angle",
    ),
    (
        "Ahead: {drive_a: 80 %",
        "Ahead: {drive_a: 80 mm",
        "80 mm",
        "expected a duty cycle such as",
    ),
    (
        "Ahead: {drive_a: 80 %",
        "Ahead: {drive_a: 80 mm/s",
        "80 mm/s",
        "'drive_a' has no wheel whose motor has a velocity loop to keep a speed",
    ),
    (
        "    no_load_speed: 5 rad/s\n",
        "    velocity_loop: {gain: 0.3}\n",
        "track:",
        "a `velocity_loop` needs the `no_load_speed` of the motor",
    ),
    (
        "    no_load_speed: 5 rad/s\n",
        "    no_load_speed: 5 rad/s\n    velocity_loop: {gain: 1.5}\n",
        "1.5",
        "expected at most 1, got '1.5'",
    ),
    ("Lit: {lamp: 60 %}", "Lit: {}", "{}", "other states of Lamp write lamp"),
    (
        "bulb: {kind: light}",
        "bulb: {kind: light, no_load_speed: 0 rad/s}",
        "0 rad/s",
        "`no_load_speed` must be more than 0",
    ),
    (
        "  Lamp:\n    Dark: {lamp: 0 %}\n    Lit: {lamp: 60 %}\n",
        "",
        "actuation:",
        "region 'Lamp' is missing here",
    ),
    ("    Lit: {lamp: 60 %}\n", "", "Lamp:", "Lamp.Lit is missing here"),
    ("    Lit: {lamp", "    Lot: {lamp", "Lot: {lamp: 60 %", "Lamp has no state 'Lot'"),
    ("  Lamp:\n    Dark", "  Lamb:\n    Dark", "Lamb:", "the chart has no region 'Lamb'"),
    ("asks_for: Crawl == Ahead", "asks_for: Crawl == Ahed", "Ahed", "'Crawl' is never 'Ahed'"),
    ("kind: turning", "kind: turing", "turing", "expected one of accepted, stalled, reached"),
    (
        "joints: [neck], loaded",
        "joints: [nec], loaded",
        "nec]",
        "whether 'nec' stands still needs a derived signal {rate_of: nec}",
    ),
    ("loaded: [neck]", "loaded: [nec]", "nec]", "'nec' is not a joint with a torque signal"),
    ("signals: [neck, hip]", "signals: [neck, hop]", "hop]", "there is no signal 'hop'"),
    ("limit: 6 deg", "limit: 6 mm", "6 mm", "'neck' is an angle"),
    ("timeout: 8 s", "timeout: 0 s", "0 s", "expected more than 0 s, got '0 s'"),
    (
        "  Rest: {asks",
        "  Rast: {asks",
        "Rast: {asks_for: Crawl =",
        "the chart has no event 'Rast'",
    ),
    ("  Rest: {asks", "  Rast: {asks", "commands:", "the chart's event 'Rest' is missing here"),
    ("aliases: {Stop: Rest}", "aliases: {Stop: Rast}", "Rast", "there is no command 'Rast'"),
    ("aliases: {Stop: Rest}", "aliases: {Home: Rest}", "Home: Rest", "'Home' is a command"),
    ("zero: [drive_a, ", "zero: [drive_x, drive_a, ", "drive_x", "there is no slot 'drive_x'"),
    (
        "zero: [drive_a, ",
        "zero: [",
        "[drive_b",
        "'drive_a' drives a wheel: it must be zero in the safe state",
    ),
    ("abs(pace) < 8 mm/s", "abs(pase) < 8 mm/s", "pase) < 8 mm/s", "unknown name 'pase'"),
    ("abs(pace) < 8 mm/s", "abs(pace) < 8", "8", "'8' needs a unit here"),
    ("held: 2 s", "held: -2 s", "-2 s", "expected at least 0 s, got '-2 s'"),
    ("code: robot.stuck", "code: stuck", "stuck", "the text 'stuck' does not fit"),
    ("code: motor.hot", "code: link.lost", "link.lost", "'link.lost' cannot be caught"),
    ("forward: {wheel: left_fore", "forward: {wheel: left", "left", "there is no wheel 'left'"),
    (_BACKWARD, "", "near:", "`forward` and `backward` belong together"),
    (_BACKWARD, _BACKWARD + "      held: 1 s\n", "near:", "`held` belongs to `when`"),
    (_POINTS, "      held: 1 s\n", "near:", "expected `forward` and `backward`, or `when`"),
    (_POINTS, "      when: wai > 1 m\n", "wai > 1 m", "unknown name 'wai'"),
    (_POINTS, "      when: way\n", "way", "a condition is expected, this is a length"),
    (_POINTS, "      {when: way > 1 m, held: -1 s}\n", "-1 s", "expected at least 0 s"),
    ("    near:\n", "    and:\n", "and:", "'and', a word of 'detector', cannot be used"),
    ("wheels: [left_hind]", "wheels: [left]", "left]", "there is no wheel 'left'"),
    ("kind: dead_wheel", "kind: dead", "dead", "expected one of dead_wheel, stiff_joint"),
    (", wheels: [left_hind]}", "}", "hind_wheel_dead: {kind:", "a dead_wheel needs `wheels`"),
    (
        ", wheels: [left_hind]}",
        ", wheels: [left_hind], raw: {rol_a: 5}}",
        "rol_a: 5",
        "there is no measured signal 'rol_a'",
    ),
    (
        "kinetic: 0.6",
        "kinetic: 0.9",
        "friction: {static: 0.8",
        "kinetic friction cannot be more than static",
    ),
    (
        "robot: newt\n",
        "robot: newt\nrobot: newt\n",
        "robot: newt",
        "the key 'robot' appears twice",
    ),
    (
        "chart: chart.yaml",
        "chart: chartt.yaml",
        "chartt.yaml",
        "chartt.yaml: there is no such file",
    ),
    ("chart: chart.yaml", "chart: .", ".", ""),
    ("format: 1", "format: 2", "2", "this program reads format 1, and this is format 2"),
    ("resend_limit: 4", "resend_limit: true", "true", "expected a whole number, got true"),
    ("cycle: 10 ms", "cycle: 10", "10", "expected a duration such as '2 s', got '10' without"),
]

_DERIVED = "  pace: {speed_of: [left_fore, right_fore, left_hind, right_hind]}\n"


def _outside(derived: str, outside: str = "ruler: {unit: m/s, valid_for: 300 ms}") -> tuple:
    """Adds derived signals, and a signal that is measured outside."""
    return _DERIVED, f"{_DERIVED}{derived}outside:\n  {outside}\n"


TRACTION_FAULTS = [
    (
        *_outside("  slid: {slip_speed_of: left, speed: ruler}\n"),
        "{slip_speed_of: left",
        "'left' is not known here",
    ),
    (
        *_outside("  slid: {slip_speed_of: left_fore, speed: rule}\n"),
        "rule}",
        "there is no outside signal 'rule'",
    ),
    (
        *_outside("  body: {robot_speed_of: [left_fore], measured: pace}\n"),
        "pace}",
        "there is no outside signal 'pace'",
    ),
    (
        *_outside(
            "  slid: {slip_speed_of: left_fore, speed: ruler}\n", "ruler: {unit: m, valid_for: 1 s}"
        ),
        "ruler}",
        "'ruler' is a length",
    ),
    (
        *_outside("  slid: {slip_of: left_fore, speed: ruler, unknown_below: 0 mm/s}\n"),
        "0 mm/s",
        "expected more than 0 mm/s, got '0 mm/s'",
    ),
    (
        *_outside(
            "  slid: {slip_speed_of: left_fore, speed: ruler}\n"
            "  again: {slip_speed_of: left_fore, speed: ruler}\n"
        ),
        "again: {",
        "'slid' is the same signal",
    ),
    (
        *_outside(
            "  body: {robot_speed_of: [left_fore], measured: ruler}\n"
            "  other: {robot_speed_of: [right_fore], measured: ruler}\n"
        ),
        "other: {",
        "'body' is the same signal",
    ),
    (
        *_outside(
            "  slid: {slip_speed_of: left_fore, speed: ruler}\n"
            "  slid_b: {slip_speed_of: right_fore, speed: camera}\n",
            "ruler: {unit: m/s, valid_for: 300 ms}\n  camera: {unit: m/s, valid_for: 300 ms}",
        ),
        "ruler}",
        "slip is measured against one speed, here against camera and ruler",
    ),
    (
        *_outside("  least: {least_of: [pace, neck_rate]}\n"),
        "least: {",
        "'neck_rate' is an angular speed, 'pace' is not",
    ),
    (
        *_outside("  press: {normal_force_of: left_fore}\n"),
        "press: {",
        "forces need every torque, that of wheel left_fore is not measured",
    ),
    (
        *_outside("  mu: {friction_of: left_fore, slip_above: 10 mm/s, steady: 500 ms}\n"),
        "mu: {",
        "forces need every torque, that of wheel left_fore is not measured",
    ),
    (
        *_outside("  mu: {friction_of: left_fore, slip_above: 0 mm/s, steady: 500 ms}\n"),
        "0 mm/s",
        "expected more than 0 mm/s, got '0 mm/s'",
    ),
    (*_outside("", "neck: {unit: m/s, valid_for: 300 ms}"), "neck: {", "'neck' is declared twice"),
    (
        *_outside("", "and: {unit: m/s, valid_for: 300 ms}"),
        "and: {",
        "'and' cannot be the name of a signal",
    ),
    (*_outside("", "ruler: {unit: mps, valid_for: 300 ms}"), "mps", "unknown unit 'mps'"),
    (*_outside("", "ruler: {unit: m/s, valid_for: 0 s}"), "0 s", "expected more than 0 s"),
    (
        "  friction: {static: 0.8",
        "  ruler: {signal: pace, every: 100 ms}\n  friction: {static: 0.8",
        "pace, every",
        "there is no outside signal 'pace'",
    ),
]

_LOOPS = (
    "    position_loop: {gain: 3.0, threshold: 3 deg, least_duty: 15 %, limit: 50 %}\n",
    "    position_loop: {gain: 3.0, threshold: 3 deg, least_duty: 15 %, limit: 50 %}\n"
    "    torque_loop: {gain: 0.6, dead: 30 mNm, within: 40 mNm, least_duty: 15 %, limit: 50 %}\n",
)


def _grip(grip: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Adds a control with this grip."""
    torques = "{fold_neck: -200 mNm, fold_hip: 200 mNm}"
    control = f"controls:\n  soft:\n    actuation: {{Grip: {{BothHeld: {torques}}}}}\n"
    return _LOOPS, ("commands:\n", f"{control}    {grip}\ncommands:\n")


GRIP_FAULTS = [
    (
        _grip("grip: {safety: 0.9, friction: {nose: 0.5, tail: 0.5}, at_most: 300 mNm}"),
        "0.9",
        "expected at least 1, got '0.9'",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 0.5}, at_most: 300 mNm}"),
        "{nose: 0.5}",
        "give the friction of each part, nose, tail",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 0.5, tail: 0.5, ear: 1}, at_most: 300 mNm}"),
        "{nose: 0.5",
        "give the friction of each part, nose, tail",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 0, tail: 0.5}, at_most: 300 mNm}"),
        "0, tail",
        "expected more than 0, got '0'",
    ),
    (
        _grip("grip: {safety: 2, friction: estimate, at_most: 300 mNm}"),
        "estimate",
        "friction is estimated by `friction_of` a wheel of nose; there is none",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 0.5, tail: 0.5}, at_most: 500 mNm}"),
        "500 mNm",
        "'fold_neck' can bear 400 mNm at its limit",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 1, tail: 1}, at_least: 0.3 Nm, at_most: 0.2 Nm}"),
        "grip: {safety",
        "`at_least` cannot be more than `at_most`",
    ),
    (
        _grip("grip: {safety: 2, friction: {nose: 1, tail: 1}, at_most: 0.2 Nm, share: half}"),
        "half",
        "expected one of as_printed, corrected",
    ),
    (
        _grip("gravity_compensation: 2"),
        "2",
        "expected true or false",
    ),
    (
        (
            ("kind: geared\n    stall_torque: 160 mNm\n", "kind: none\n"),
            ("    hold_torque: 160 mNm\n", "    velocity_loop: {gain: 0.3}\n"),
            (
                "commands:\n",
                "controls:\n  kept: {actuation: {Crawl: {Ahead: {drive_a: 50 mm/s,"
                " drive_b: -50 mm/s, drive_c: 50 mm/s, drive_d: -50 mm/s}}}}\n"
                "  level: {extends: kept, gravity_compensation: false}\n"
                "  bears: {extends: level, gravity_compensation: true}\ncommands:\n",
            ),
        ),
        "true}",
        "gravity compensation needs the `stall_torque` of the motor of 'drive_a'",
    ),
]
