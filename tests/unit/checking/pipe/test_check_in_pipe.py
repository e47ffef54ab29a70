"""A mission that does not fit its pipe is told, once, with its numbers; shipped ones do fit."""

from __future__ import annotations

from math import asin, cos, radians, sin
from pathlib import Path

import pytest
from representative import MISSIONS as REPRESENTATIVE
from representative import thorough_but

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.findings import Severity
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.core import library
from pirate_sm.core.loading import load_mission

from ..robots import NEWT, PIRATE, ROOT, changed, told
from .small_missions_in_pipes import findings, found_in, mission, pipe

MISSIONS = [
    *library.missions(),
    *sorted((ROOT / "docs" / "examples").glob("*.yaml")),
    NEWT / "patrol.yaml",
    NEWT / "take_hold.yaml",
]
BENT = "[{straight: 1 m}, {mitre: 90 deg}, {straight: 1 m}], start: {at: 700 mm}"
ROUND = "[ClampFront, ClampRear, RelaxFront, BendInto, ClampFront, RelaxRear, BendBack, ClampRear]"
BACK = "[ClampFront, ClampRear, RelaxRear, BendInto, ClampRear, RelaxFront, BendBack, ClampFront]"


@pytest.mark.parametrize(
    "path",
    thorough_but([each for each in MISSIONS if each.stem in REPRESENTATIVE], MISSIONS),
    ids=lambda path: path.stem,
)
def test_shipped_missions_fit_their_pipes(path: Path) -> None:
    found = found_in(load_mission(path))
    assert [each for each in found if "pirate: allow" not in each.excerpt] == []


def test_a_mission_without_a_pipe_is_left_alone(tmp_path: Path) -> None:
    text = mission(ROUND, "x").replace("pipe: x\n", "")

    assert findings(tmp_path, text) == ()


# --- the side of a bend ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("mitre_bend", "mitre_90_other_side"),
        ("mitre_bend_other_side", "mitre_90"),
        ("exp_2b_detector", "mitre_90_other_side"),
        ("prepare_bend", "mitre_90_other_side"),
        ("pass_bend", "mitre_90_other_side"),
    ],
)
def test_a_bend_to_the_other_side_is_reported(name: str, other: str) -> None:
    loaded = load_mission(library.find_mission(name), pipe=other)

    (found,) = found_in(loaded)

    key = "polarity:" if loaded.mission.polarity else "pipe:"
    assert found.code == "geometry.polarity"
    assert found.excerpt.startswith(key)
    assert "polarity: " in found.fix
    assert all(place.line for place, _ in found.related)


@pytest.mark.parametrize(
    ("do", "angle", "polarity", "fits"),
    [
        (ROUND, 90, "normal", True), (ROUND, 90, "mirrored", False),
        (ROUND, -60, "normal", False), (ROUND, -60, "mirrored", True),
        (BACK, 90, "normal", False), (BACK, 90, "mirrored", True),
        (BACK, -60, "normal", True), (BACK, -60, "mirrored", False),
    ],
)  # fmt: skip
def test_the_inner_wall_needs_its_polarity(
    tmp_path: Path, do: str, angle: int, polarity: str, fits: bool
) -> None:
    segments = BENT.replace("90", str(angle)).replace(
        "700 mm", "700 mm" if do == ROUND else "1.7 m"
    )

    found = findings(tmp_path, mission(do, pipe(segments), f"polarity: {polarity}"))

    assert [(each.code, each.excerpt) for each in found] == (
        [] if fits else [("geometry.polarity", f"polarity: {polarity}")]
    )


def test_only_missions_that_bend_are_asked_for_the_side(tmp_path: Path) -> None:
    text = mission("[ClampFront, ClampRear, DriveForward, Brake]", pipe(BENT), "polarity: mirrored")

    assert findings(tmp_path, text) == ()


def test_what_only_follows_a_failure_is_not_what_the_mission_is_for(tmp_path: Path) -> None:
    text = mission("[ClampFront, ClampRear]", pipe(BENT), "polarity: mirrored", "on_failure: b")
    text = text.replace("ends:", "  b: {do: [RelaxFront, BendInto], go: e}\nends:")

    assert findings(tmp_path, text) == ()


def test_a_part_that_is_turned_may_bend_anywhere(tmp_path: Path) -> None:
    do = ROUND.replace("RelaxFront,", "RelaxFront, AlignRight,", 1)

    assert findings(tmp_path, mission(do, pipe(BENT), "polarity: mirrored")) == ()


def test_another_robot_bends_by_its_own_states(tmp_path: Path) -> None:
    robot = changed(
        NEWT, tmp_path, "chart.yaml",
        ("- {event: HoldTail, target: Grip.BothHeld",
         "- {event: Peek, target: Grip.TailBent}\n"
         "              - {event: HoldTail, target: Grip.BothHeld"),
        ("          Grip.TailHeld:\n",
         "          Grip.TailBent:\n            transitions:\n"
         "              - {event: HoldTail, target: Grip.BothHeld}\n          Grip.TailHeld:\n"),
    )  # fmt: skip
    profile = robot / "profile.yaml"
    text = profile.read_text(encoding="utf-8")
    text = text.replace("(NoseHeld, BothHeld)", "(NoseHeld, BothHeld, TailBent)")
    text = text.replace(
        "    BothHeld:", "    TailBent: {fold_neck: -50 %, fold_hip: 30 deg}\n    BothHeld:", 1
    ).replace(
        "  Rest: {asks",
        "  Peek: {asks_for: Grip == TailBent, done: {kind: reached}, timeout: 2 s, nominal: 1 s}\n"
        "  Rest: {asks",
    )
    profile.write_text(text, encoding="utf-8")
    bends = mission("[HoldNose, Peek]", "newt/elbow.yaml").replace(
        "robot: pirate_ii", "robot: newt"
    )

    assert findings(tmp_path, bends) == ()
    (found,) = findings(tmp_path, bends.replace("start:", "polarity: mirrored\nstart:", 1))
    assert found.code == "geometry.polarity"
    assert "'tail'" in found.message
    assert "-60 deg" in found.message


@pytest.mark.parametrize("roll", ["30 deg", "-90 deg", "180 deg"])
def test_a_bend_out_of_the_robots_plane_is_reported(tmp_path: Path, roll: str) -> None:
    found = findings(tmp_path, mission(ROUND, pipe(BENT, f", roll: {roll}")))

    assert [code for code, _ in told(found)] == ["geometry.out_of_plane"]
    assert told(found)[0][1].startswith(roll)


def test_a_little_roll_does_no_harm(tmp_path: Path) -> None:
    assert findings(tmp_path, mission(ROUND, pipe(BENT, ", roll: 9 deg"))) == ()


# --- room --------------------------------------------------------------------------------------

STILL = "[ClampFront]"


@pytest.mark.parametrize(
    ("segments", "at", "said"),
    [
        (BENT.replace("700", "950"), "950 mm", "is in the bend at 1000 mm"),
        (BENT.replace("700", "945"), "945 mm", "is in the bend"),
        (BENT.replace("700", "1200"), "1200 mm", "is in the bend"),
        (BENT.replace("700", "400"), "400 mm", "juts out of the beginning"),
        ("[{straight: 400 mm}]", "{straight: 400 mm}", "juts out of the beginning"),
        ("[{straight: 300 mm}, {mitre: 90 deg}, {straight: 2 m}]", "{straight: 300 mm}",
         "juts out of the beginning"),
    ],
)  # fmt: skip
def test_a_robot_that_does_not_fit_where_it_begins_is_reported(
    tmp_path: Path, segments: str, at: str, said: str
) -> None:
    found = findings(tmp_path, mission(STILL, pipe(segments)))

    assert [code for code, _ in told(found)] == ["geometry.too_close"]
    assert told(found)[0][1].startswith(at)
    assert said in found[0].message
    assert "458 mm long" in found[0].message


@pytest.mark.parametrize("place", ["459 mm", "939 mm", "1520 mm", "1999 mm"])
def test_a_robot_may_begin_close_to_a_bend(tmp_path: Path, place: str) -> None:
    assert findings(tmp_path, mission(STILL, pipe(BENT.replace("700 mm", place)))) == ()


def test_a_clamped_robot_is_shorter(tmp_path: Path) -> None:
    text = mission("[DriveForward]", pipe(BENT.replace("700", "330")), "starts_in: STATES")
    held = "{BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}"

    assert findings(tmp_path, text.replace("STATES", held)) == ()
    assert findings(tmp_path, text.replace("starts_in: STATES\n", "").replace("DriveF", "ClampF")
                    .replace("ClampForward", "ClampFront"))  # fmt: skip


def test_a_mission_that_begins_in_the_bend_may_stand_there(tmp_path: Path) -> None:
    states = "{BendingState: RearClampedFrontBending, RearWheelsState: Fixed}"

    text = mission("[DriveForward]", pipe(BENT.replace("700", "1050")), f"starts_in: {states}")

    assert findings(tmp_path, text) == ()


@pytest.mark.parametrize(
    ("do", "segments", "at"),
    [
        (ROUND, BENT.replace("}, {straight: 1 m}]", "}, {straight: 340 mm}]"), "340 mm"),
        (ROUND, BENT.replace("}, {straight: 1 m}]",
                             "}, {straight: 390 mm}, {mitre: 80 deg}, {straight: 1 m}]"), "390 mm"),
        (BACK, "[{straight: 340 mm}, {mitre: -90 deg}, {straight: 1 m}], start: {at: 1.1 m}",
         "340 mm"),
    ],
)  # fmt: skip
def test_a_leg_that_is_too_short_to_stand_in_is_reported(
    tmp_path: Path, do: str, segments: str, at: str
) -> None:
    found = findings(tmp_path, mission(do, pipe(segments)))

    assert [code for code, _ in told(found)] == ["geometry.too_short"]
    assert told(found)[0][1].startswith(at)
    assert "282.5 mm long" in found[0].message


def test_a_leg_in_which_nothing_stands_may_be_short(tmp_path: Path) -> None:
    short = BENT.replace("}, {straight: 1 m}]", "}, {straight: 200 mm}]")

    assert (
        findings(tmp_path, mission("[ClampFront, ClampRear, RelaxFront, BendInto]", pipe(short)))
        == ()
    )


# --- forces ------------------------------------------------------------------------------------

UP = ", tilt: 90 deg, start: {at: 600 mm}"
HELD = "starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}"


def slippery(static: float, rest: str = UP) -> str:
    friction = f", friction: {{static: {static}, kinetic: {static / 2}}}"
    return pipe("[{straight: 2 m}]", friction + rest)


def test_a_wall_too_slippery_for_every_clamp_is_told_at_the_pipe(tmp_path: Path) -> None:
    found = findings(tmp_path, mission("[DriveForward, Brake]", slippery(0.05), HELD))

    assert told(found)[0][0] == "geometry.clamp_torque"
    assert told(found)[0][1].startswith("90 deg")
    assert found[0].severity is Severity.ERROR
    # 4 * 0.707 Nm / 54 mm for each part; (4 * 130 + 150 + 6 * 20) g pull with 7.75 N.
    assert "105 N" in found[0].message
    assert "5.24 N" in found[0].message
    assert "7.75 N" in found[0].message


def test_a_step_that_leaves_too_little_is_told_itself(tmp_path: Path) -> None:
    found = findings(tmp_path, mission("[RelaxFront, BendInto]", slippery(0.1), HELD))

    assert told(found)[0] == ("geometry.clamp_torque", "RelaxFront, BendInto], go: e}")
    assert "'rear', clamped with 0.707 Nm" in found[0].message


def test_a_called_step_is_told_in_its_own_file(tmp_path: Path) -> None:
    called = mission("[RelaxFront]", "x", HELD).replace("pipe: x\n", "").replace("m: m", "m: n")
    (tmp_path / "n.yaml").write_text(called, encoding="utf-8")

    found = findings(tmp_path, mission("[{call: n}]", slippery(0.1), HELD))

    assert [each.place.file.rpartition("/")[2] for each in found] == ["n.yaml"]
    assert told(found)[0][1].startswith("RelaxFront")


@pytest.mark.parametrize(("static", "severity"), [(0.2, None), (0.15, None), (0.14, "error")])
def test_what_holds_depends_on_friction(
    tmp_path: Path, static: float, severity: str | None
) -> None:
    found = findings(tmp_path, mission("[RelaxFront]", slippery(static), HELD))

    assert [each.severity.word for each in found] == ([severity] if severity else [])


def test_weight_that_rests_on_the_wall_makes_it_less_certain(tmp_path: Path) -> None:
    steep = ", tilt: 40 deg, start: {at: 600 mm}"

    found = findings(tmp_path, mission("[RelaxFront]", slippery(0.09, steep), HELD))

    assert [each.severity for each in found] == [Severity.WARNING]


@pytest.mark.parametrize(
    ("tilt", "uphill", "do", "weak"),
    [
        (0, 0, ROUND, False), (90, 90, "[ClampFront, ClampRear, RelaxFront]", False),
        (90, 90, ROUND, True), (90, 0, "[ClampFront]", True), (90, 180, "[ClampFront]", True),
    ],
)  # fmt: skip
def test_each_leg_has_its_own_slope(
    tmp_path: Path, tilt: int, uphill: int, do: str, weak: bool
) -> None:
    rest = f", tilt: {tilt} deg, uphill: {uphill} deg, friction: {{static: 0.1, kinetic: 0.1}}"

    found = findings(tmp_path, mission(do, pipe(BENT, rest)))

    assert [each.code for each in found] == ["geometry.clamp_torque"] * weak


def test_a_weak_motor_is_told_with_the_robots_own_friction(tmp_path: Path) -> None:
    changed(PIRATE, tmp_path, "profile.yaml", ("stall_torque: 1.01 Nm", "stall_torque: 0.15 Nm"))
    profile = tmp_path / PIRATE.name / "profile.yaml"
    text = profile.read_text(encoding="utf-8")
    usual, others = text.index("controls:\n"), text.index("# --- Postures that")
    profile.write_text(text[:usual] + text[others:], encoding="utf-8")  # they ask for 350 mNm
    climb = (ROOT / "sequences" / "climb.yaml").read_text(encoding="utf-8")

    text = climb.replace("do: [Brake, {log", "do: [Brake, RelaxFront, {log")
    found = findings(tmp_path, text.replace("robot: pirate_ii", "robot: ./pirate_ii"))

    assert [each.code for each in found] == ["geometry.clamp_torque"]
    assert "RelaxFront" in found[0].excerpt


WEAK = """\
  weak:
    extends: exp_3a
    actuation:
      BendingState: {DoubleClamped: {bend_1: -60 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 60 mNm}}
  assuming:
    extends: exp_3a
    grip: {safety: 1.5, friction: {front: 0.5, rear: 0.5}, at_most: 700 mNm}
  exp_3b:
"""


def with_control(folder: Path, text: str) -> str:
    """The mission with a robot that has controls which press less."""
    if not (folder / PIRATE.name).exists():
        changed(PIRATE, folder, "profile.yaml", ("  exp_3b:\n", WEAK))
    return text.replace("robot: pirate_ii", "robot: ./pirate_ii")


@pytest.mark.parametrize(
    ("control", "static", "weak"),
    [
        ("exp_3a", 0.3, False), ("weak", 0.3, True), ("weak", 1.0, False),
        # a grip presses for the friction that it assumes, and up to 700 mNm if a wheel slips
        ("assuming", 0.5, False), ("assuming", 0.1, True), ("careful", 0.1, False),
    ],
)  # fmt: skip
def test_a_clamp_is_judged_by_the_control_in_force(
    tmp_path: Path, control: str, static: float, weak: bool
) -> None:
    steps = f"[Brake, {{control: {control}}}, DriveForward, {{control: none}}]"
    do = mission(steps.replace("Brake, ", ""), slippery(static), HELD)

    found = findings(tmp_path, with_control(tmp_path, do))

    assert [(each.code, each.excerpt.strip()[:8]) for each in found] == (
        [("geometry.clamp_torque", "a: {do: ")] if weak else []
    )
    if weak:
        assert found[0].excerpt[found[0].place.column - 1 :].startswith(f"{{control: {control}")
        assert f"under the control '{control}'" in found[0].message


def test_a_grip_that_may_press_harder_is_no_certain_fall(tmp_path: Path) -> None:
    do = mission("[{control: assuming}]", slippery(0.1), HELD)

    (found,) = findings(tmp_path, with_control(tmp_path, do))

    assert found.severity is Severity.WARNING


def test_the_control_at_a_missions_head_is_in_force_from_its_first_step(tmp_path: Path) -> None:
    do = mission("[DriveForward]", slippery(0.3), HELD, "control: weak")

    (found,) = findings(tmp_path, with_control(tmp_path, do))

    assert found.severity is Severity.ERROR
    assert "clamped with 0.06 Nm and 0.06 Nm, under the control 'weak'" in found.message


PATCH = ", patches: [{from: 1.2 m, to: 1.6 m, static: 0.05, kinetic: 0.04}]"


@pytest.mark.parametrize(
    ("do", "rest", "weak"),
    [
        ("[DriveForward, Brake]", PATCH, True),
        ("[ToggleLighting]", PATCH, False),  # it never comes there
        ("[ToggleLighting]", PATCH.replace("1.2 m, to: 1.6 m", "100 mm, to: 700 mm"), True),
        # one wheel on ice is borne by the others
        ("[DriveForward, Brake]", PATCH.replace("to: 1.6 m", "to: 1.21 m"), False),
        ("[DriveForward, Brake]", PATCH.replace("static: 0.05", "static: 0.3"), False),
    ],
)
def test_a_patch_of_less_friction_on_the_way_is_reported(
    tmp_path: Path, do: str, rest: str, weak: bool
) -> None:
    found = findings(tmp_path, mission(do, slippery(0.3, UP + rest), HELD))

    assert [each.code for each in found] == ["geometry.clamp_torque"] * weak
    if weak:
        assert "part of it on a patch" in found[0].message


def test_a_patch_that_the_robot_may_leave_out_is_no_certain_fall(tmp_path: Path) -> None:
    drive = mission("[DriveForward, Brake]", slippery(0.3, UP + PATCH), HELD)
    stand = drive.replace("from: 1.2 m, to: 1.6 m", "from: 100 mm, to: 700 mm")

    assert [each.severity for each in findings(tmp_path, drive)] == [Severity.WARNING]
    stand = stand.replace("DriveForward, Brake", "ToggleLighting")
    assert [each.severity for each in findings(tmp_path, stand)] == [Severity.ERROR]


@pytest.mark.parametrize(
    ("limit", "weak"), [("10 min", True), ("19 s", False), ("29 s", True), ("21 s", False)]
)
def test_a_pipe_that_turns_is_judged_by_the_tilt_that_it_comes_to(
    tmp_path: Path, limit: str, weak: bool
) -> None:
    rest = ", start: {at: 600 mm}, turns: {from: 20 s, to: 30 s, tilt: 90 deg}"

    text = mission("[DriveForward]", slippery(0.06, rest), HELD, f"time_limit: {limit}")
    found = findings(tmp_path, text)

    assert [each.severity for each in found] == [Severity.WARNING] * weak
    assert all("once it has turned" in each.message for each in found)


def test_a_pipe_that_turns_level_is_judged_by_the_tilt_that_it_has_at_first(
    tmp_path: Path,
) -> None:
    level = UP + ", turns: {from: 20 s, to: 30 s, tilt: 0 deg}"

    (found,) = findings(tmp_path, mission("[DriveForward]", slippery(0.05, level), HELD))

    assert "turned" not in found.message


def test_forces_are_those_of_the_thesis() -> None:
    loaded = load_mission(library.find_mission("climb"))
    assert loaded.pipe is not None
    fit = Fit(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
    configuration = loaded.program.start_configuration

    gamma = 2 * asin(fit.height_m(0.12) / 0.09)  # eq. 3-2
    expected = 4 * 0.7 * 1.01 / (0.09 * cos(gamma / 2))  # eq. 3-3, sqrt(l^2 - h^2) = l cos(gamma/2)
    for part in (0, 1):
        usual_nm, most_nm = fit.torques_nm(part, Actuated(configuration), 0.12)
        assert usual_nm == most_nm
        assert fit.press_n(part, usual_nm, 0.12) == pytest.approx(expected)
    assert fit.weight_n == pytest.approx(0.79 * 9.81)
    # docs: a vertical pipe needs about 0.21 Nm with one part at a friction of 0.5.
    assert expected * 0.21 / 0.707 * 0.5 == pytest.approx(fit.weight_n, rel=0.02)


def test_the_weight_pulls_along_a_piece_that_climbs() -> None:
    loaded = load_mission(library.find_mission("exp_2c_tilted"))
    assert loaded.pipe is not None
    fit = Fit(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
    first, second = fit.route.pieces

    assert fit.pull_n(first) == pytest.approx((0.0, fit.weight_n), abs=1e-9)
    assert fit.pull_n(second)[0] == pytest.approx(fit.weight_n * sin(radians(28)))
