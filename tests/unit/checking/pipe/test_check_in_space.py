"""Missions in round pipes: rolls of parts, tees, diameters and climbs go by the route."""

from __future__ import annotations

from math import asin, degrees
from pathlib import Path

import pytest

from pirate_sm.checking.findings import Finding, Severity

from ..robots import PIRATE, changed, told
from .small_missions_in_pipes import findings, mission

FIRST = "ClampFront, ClampRear, RelaxFront, BendInto, ClampFront, RelaxRear, BendBack, ClampRear"
AGAIN = FIRST.replace("ClampFront, ClampRear, ", "", 1)
DRIVE = "DriveForward, Brake"
RIGHT = "RelaxFront, AlignRight, ClampFront, RelaxRear, AlignStraight, ClampRear"
LEFT = RIGHT.replace("AlignRight", "AlignLeft")
REAR = "RelaxRear, BendInto, DriveBackward, Brake, ClampRear, RelaxFront, BendBack, ClampFront"

UP = "{mitre: 90 deg, roll: 90 deg}"
TO_A = "{mitre: 90 deg}"
TEE = "{tee: 90 deg, take: on}"


def space(*fittings: str, start: str = "at: 700 mm", rest: str = "") -> str:
    segments = ", ".join(f"{each}, {{straight: 1 m}}" for each in fittings)
    return (
        f"{{section: round, diameter: 120 mm, segments: [{{straight: 1 m}}, {segments}],"
        f" start: {{{start}}}{rest}}}"
    )


def found(folder: Path, do: str, pipe: str, *lines: str) -> tuple[Finding, ...]:
    return findings(folder, mission(f"[{do}]", pipe, *lines))


# --- the planes of bends -----------------------------------------------------------------------


@pytest.mark.parametrize("fitting", [UP, "{elbow: 90 deg, radius: 180 mm, roll: 90 deg}",
                                     "{tee: 90 deg, take: branch, roll: 90 deg}"])  # fmt: skip
def test_a_part_that_bends_out_of_the_plane_is_told_with_the_turn_that_is_missing(
    tmp_path: Path, fitting: str
) -> None:
    (missed,) = found(tmp_path, FIRST, space(fitting))

    assert missed.code == "geometry.out_of_plane"
    assert told([missed])[0][1].startswith("BendInto")
    assert "'front' is bent 90 deg out of the plane" in missed.message
    assert "one quarter turn is missing" in missed.message
    assert missed.fix.startswith("'AlignRight' turns 'front' there")
    (into, words) = missed.related[0]
    written = (tmp_path / "m.yaml").read_text(encoding="utf-8").splitlines()[into.line - 1]
    assert written[into.column - 1 :].startswith(fitting)
    assert words == "into this"
    assert missed.story[0] == "the mission begins"
    assert missed.story[-1].startswith("BendInto")


@pytest.mark.parametrize(
    ("roll", "angle", "command"),
    [(90, 90, "AlignRight"), (-90, 90, "AlignLeft"), (90, -90, "AlignLeft")],
)
def test_the_command_that_is_named_mends_it(
    tmp_path: Path, roll: int, angle: int, command: str
) -> None:
    pipe = space(f"{{mitre: {angle} deg, roll: {roll} deg}}")

    (missed,) = found(tmp_path, FIRST, pipe)
    assert missed.fix.startswith(f"'{command}'")
    turned = FIRST.replace("RelaxFront,", f"RelaxFront, {command},", 1)
    (missed,) = found(tmp_path, turned, pipe)
    assert "'rear' is bent 90 deg" in missed.message
    assert missed.fix.startswith("'AlignStraight' turns 'rear'")
    assert "it rolls 'front' by" in "".join(missed.story)
    turned = turned.replace("RelaxRear,", "RelaxRear, AlignStraight,", 1)
    assert found(tmp_path, turned, pipe) == ()


def test_a_robot_that_starts_rolled_bends_in_its_own_plane(tmp_path: Path) -> None:
    rolled = space(UP, start="at: 700 mm, roll: 90 deg")

    assert found(tmp_path, FIRST, rolled) == ()
    assert found(tmp_path, FIRST, space(UP, rest=", roll: -90 deg")) == ()
    assert found(tmp_path, FIRST, space(UP, start="at: 700 mm, roll: 82 deg")) == ()
    (missed,) = found(tmp_path, FIRST, space(UP, start="at: 700 mm, roll: 40 deg"))
    assert "50 deg out of the plane" in missed.message
    assert missed.fix.startswith("no quarter turn brings it there")


def test_the_inner_wall_goes_by_the_roll(tmp_path: Path) -> None:
    half = space(UP, start="at: 700 mm, roll: -90 deg")

    (missed,) = found(tmp_path, FIRST, half)

    assert missed.code == "geometry.polarity"
    assert "'front' is bent away from the inner wall of the mitre of 90 deg" in missed.message
    assert found(tmp_path, FIRST, half, "polarity: mirrored") == ()
    assert found(tmp_path, FIRST, space("{mitre: -90 deg}"), "polarity: mirrored") == ()


def test_two_bends_in_two_planes_need_the_turn_between(tmp_path: Path) -> None:
    pipe = space(TO_A, UP)

    (missed,) = found(tmp_path, f"{FIRST}, {DRIVE}, {AGAIN}", pipe)

    assert "the mitre of 90 deg at 2000 mm" in missed.message
    assert found(tmp_path, f"{FIRST}, {DRIVE}, {RIGHT}, {AGAIN}", pipe) == ()
    (missed,) = found(tmp_path, f"{FIRST}, {DRIVE}, {LEFT}, {AGAIN}", pipe)
    assert missed.code == "geometry.polarity"
    both = found(tmp_path, f"{FIRST}, {DRIVE}, {RIGHT}, {AGAIN}", space(UP, TO_A))
    assert [each.message.partition(" at ")[2][:7] for each in both] == ["1000 mm", "2000 mm"]


def test_a_bend_that_is_passed_back_is_judged_on_its_own(tmp_path: Path) -> None:
    back = f"{FIRST}, DriveForward, DriveBackward, Brake, {REAR}"

    (missed,) = found(tmp_path, back, space(TO_A, UP))

    assert missed.code == "geometry.polarity"
    assert "'rear' is bent away" in missed.message
    assert "at 1000 mm" in missed.message


def test_a_bend_behind_the_start_counts_for_who_goes_backward(tmp_path: Path) -> None:
    start = "at: 1.7 m"
    pipe = space("{mitre: -90 deg}", UP, start=start)

    back = f"ClampFront, ClampRear, {REAR}"
    assert found(tmp_path, back, pipe) == ()
    (missed,) = found(tmp_path, FIRST, pipe)
    assert "at 2000 mm" in missed.message


def test_a_mission_that_turns_where_it_may_is_left_alone(tmp_path: Path) -> None:
    turn = f"{{choose: [{{if: odometry > 100 mm, do: [{RIGHT}]}}]}}"

    assert found(tmp_path, f"ClampFront, ClampRear, {turn}, {AGAIN}", space(UP)) == ()


def test_nobody_knows_the_roll_of_a_robot_that_has_let_go(tmp_path: Path) -> None:
    do = f"ClampFront, ClampRear, RelaxFront, {{command: Reset, on_failure: continue}}, {FIRST}"

    assert found(tmp_path, do, space(UP)) == ()


def test_each_bend_is_named_at_its_own_place(tmp_path: Path) -> None:
    tee = "{tee: 90 deg, take: on, roll: 90 deg}"
    branch = "{tee: 90 deg, take: branch, roll: 90 deg, stub: 300 mm}"
    elbow = "{elbow: 45 deg, radius: 200 mm, roll: 90 deg}"
    step = "{reducer: 0 mm, to: 110 mm}"

    missed = found(
        tmp_path, f"{FIRST}, {DRIVE}, {AGAIN}, {DRIVE}, {AGAIN}",
        space(tee, step, "{mitre: 45 deg, roll: 90 deg}", tee, elbow, branch),
    )  # fmt: skip

    written = (tmp_path / "m.yaml").read_text(encoding="utf-8").splitlines()
    places = [each.related[0][0] for each in missed]
    assert [written[each.line - 1][each.column - 1 :][:12] for each in places] == [
        "{mitre: 45 d", "{elbow: 45 d", "{tee: 90 deg"]  # fmt: skip
    assert [each.code for each in missed] == ["geometry.out_of_plane"] * 3


def test_a_route_is_followed_through_its_network(tmp_path: Path) -> None:
    pipe = (
        "{section: round, diameter: 120 mm,"
        " runs: {main: {from: a, to: t, segments: [{straight: 1 m}]},"
        " past: {from: t.on, to: b, segments: [{straight: 1 m}]},"
        " up: {from: t.branch, to: c, segments: [{straight: 1 m}]}},"
        " junctions: {t: {tee: 90 deg, roll: 90 deg}}, ends: {a: open, b: closed, c: open},"
        " routes: {on: [main, past], off: [main, up], back: [up, main]},"
        " start: {run: START}}"
    )
    main = pipe.replace("START", "main, at: 700 mm")

    (missed,) = found(tmp_path, FIRST, main, "route: off")
    assert "the plane of the tee 't'" in missed.message
    assert [code for code, _ in told(found(tmp_path, FIRST, main, "route: on"))] == [
        "geometry.no_bend", "geometry.no_bend"]  # fmt: skip
    back = pipe.replace("START", "up, at: 300 mm")
    (missed,) = found(tmp_path, FIRST, back, "route: back")
    assert missed.fix.startswith("'AlignRight' turns 'front'")


# --- tees that are passed straight on ----------------------------------------------------------


@pytest.mark.parametrize(
    ("tee", "start", "told_of"),
    [
        (TEE, "at: 700 mm", "120 mm"),
        (TEE.replace("on}", "on, roll: 180 deg}"), "at: 700 mm", "120 mm"),
        (TEE, "at: 700 mm, roll: 30 deg", "120 mm"),
        (TEE, "at: 700 mm, roll: 50 deg", "120 mm"),
        (TEE, "at: 700 mm, roll: 55 deg", ""),
        (TEE, "at: 700 mm, roll: 90 deg", ""),
        (TEE.replace("on}", "on, roll: -90 deg}"), "at: 700 mm", ""),
        (TEE.replace("on}", "on, diameter: 50 mm}"), "at: 700 mm", "50 mm"),
        (TEE.replace("on}", "on, diameter: 40 mm}"), "at: 700 mm", ""),
    ],
)
def test_a_part_whose_wheels_sink_into_the_mouth_of_a_tee_is_reported(
    tmp_path: Path, tee: str, start: str, told_of: str
) -> None:
    missed = found(tmp_path, f"ClampFront, ClampRear, {DRIVE}", space(tee, start=start))

    assert [code for code, _ in told(missed)] == ["tee.in_plane"] * bool(told_of)
    for each in missed:
        assert each.severity is Severity.WARNING
        assert f"sink into the mouth of {told_of}" in each.message
        assert each.message.startswith("if the robot drives so far: 'front' passes")
        assert each.excerpt[each.place.column - 1 :].startswith("DriveForward")


def test_a_tee_before_a_bend_is_certainly_passed(tmp_path: Path) -> None:
    hold = "ClampFront, ClampRear"

    (missed,) = found(tmp_path, f"{hold}, {DRIVE}, {AGAIN}", space(TEE, TO_A))

    assert (missed.code, missed.severity) == ("tee.in_plane", Severity.ERROR)
    assert missed.message.startswith("'front' passes the tee 'tee_1'")
    square = f"{hold}, {RIGHT}, {DRIVE}, {LEFT}, {AGAIN}"
    assert found(tmp_path, square, space(TEE, TO_A)) == ()


def test_a_tee_behind_the_robot_or_behind_a_bend_in_which_it_stays_is_none_of_its_business(
    tmp_path: Path,
) -> None:
    hold = "ClampFront, ClampRear"

    assert found(tmp_path, f"{hold}, {DRIVE}", space(TEE, start="at: 1.7 m")) == ()
    assert found(tmp_path, f"{hold}, {DRIVE}", space(TO_A, TEE)) == ()
    assert found(tmp_path, hold, space(TEE)) == ()
    (missed,) = found(tmp_path, f"{hold}, DriveBackward", space(TEE, start="at: 1.7 m"))
    assert missed.code == "tee.in_plane"
    (missed,) = found(tmp_path, f"{FIRST}, {DRIVE}", space(TO_A, TEE))
    assert missed.code == "tee.in_plane"


# --- turning ------------------------------------------------------------------------------------


def without_posture(folder: Path) -> None:
    changed(PIRATE, folder, "profile.yaml",
            *((f"Aligned{side}\n    posture: slack\n", f"Aligned{side}\n")
              for side in ("Straight", "Left", "Right")))  # fmt: skip


@pytest.mark.parametrize(
    ("do", "code", "said"),
    [
        ("ClampFront, ClampRear, RelaxFront, AlignRight", "align.wound", "'front', which still"),
        ("ClampRear, ClampFront, RelaxRear, AlignLeft", "align.wound", "'rear', which still"),
        ("ClampRear, AlignRight", "align.oblique", "47 deg off the pipe's axis in 120 mm"),
        ("ClampFront, ClampRear, RelaxFront, BendInto, AlignRight", "align.oblique",
         "'front', which is bent"),
    ],
)  # fmt: skip
def test_what_turns_without_a_posture_is_reported(
    tmp_path: Path, do: str, code: str, said: str
) -> None:
    without_posture(tmp_path)
    text = mission(f"[{do}]", space(TO_A)).replace("robot: pirate_ii", "robot: ./pirate_ii")

    (missed,) = [each for each in findings(tmp_path, text) if each.code.startswith("align.")]

    assert missed.code == code
    assert said in missed.message
    assert told([missed])[0][1].startswith("Align")
    assert missed.story[-1].startswith("Align")
    (elsewhere := tmp_path / "elsewhere").mkdir()
    shipped = findings(elsewhere, text.replace("./pirate_ii", "pirate_ii"))
    assert [each for each in shipped if each.code.startswith("align.")] == []


def test_the_module_stands_as_obliquely_as_the_pipe_is_wide(tmp_path: Path) -> None:
    without_posture(tmp_path)
    pipe = space(TO_A).replace("120 mm", "60 mm")
    text = mission("[ClampRear, AlignRight]", pipe).replace(
        "robot: pirate_ii", "robot: ./pirate_ii"
    )

    (missed,) = findings(tmp_path, text)

    assert f"{degrees(asin((60 - 48) / 98)):.2g} deg off" in missed.message
    assert findings(tmp_path, text.replace("60 mm", "57 mm")) == ()


# --- room ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fitting", "at", "said"),
    [
        (TEE, "1.2 m", "is in the tee 'tee_1' at 1000 mm, whose opening begins at 940 mm"),
        (TEE, "950 mm", "is in the tee"),
        (TEE.replace("on}", "on, diameter: 80 mm}"), "1.2 m", "whose opening begins at 960 mm"),
        ("{elbow: 90 deg, radius: 180 mm}", "1.1 m", "the elbow from 1000 mm to 1283 mm"),
        ("{elbow: 90 deg, radius: 180 mm}", "1.7 m", "the elbow"),
        ("{reducer: 60 mm, to: 100 mm}", "1.3 m", "the reducer that begins at 1000 mm"),
        ("{reducer: 0 mm, to: 100 mm}", "1.3 m", "the reducer that begins at 1000 mm"),
    ],
)
def test_a_robot_that_does_not_start_between_two_joints_is_reported(
    tmp_path: Path, fitting: str, at: str, said: str
) -> None:
    (missed,) = found(tmp_path, "ClampFront", space(fitting, start=f"at: {at}"))

    assert missed.code == "geometry.too_close"
    assert said in missed.message
    assert told([missed])[0][1].startswith(at)
    assert found(tmp_path, "ClampFront", space(fitting, start="at: 930 mm")) == ()
    assert found(tmp_path, "ClampFront", space(fitting, start="at: 1.8 m")) == ()


@pytest.mark.parametrize(
    ("segments", "room"),
    [
        ("{mitre: 90 deg}, {straight: 330 mm}", "270 mm"),
        ("{elbow: 90 deg, radius: 180 mm}, {straight: 270 mm}", "270 mm"),
        ("{elbow: 90 deg, radius: 180 mm}, {straight: 283 mm}", ""),
        ("{elbow: 90 deg, radius: 180 mm}, {straight: 250 mm},"
         " {elbow: -90 deg, radius: 180 mm}, {straight: 1 m}", "250 mm"),
        ("{tee: 90 deg, take: branch}, {straight: 330 mm}", "270 mm"),
        # the robot is longer where the pipe is narrower
        ("{mitre: 90 deg}, {straight: 100 mm}, {reducer: 60 mm, to: 100 mm},"
         " {straight: 200 mm}", ""),
        # a tee takes its mouth from the straight that it lies in
        ("{mitre: 90 deg}, {straight: 300 mm}, {tee: 90 deg, take: on, roll: 90 deg},"
         " {straight: 300 mm}", "240 mm"),
    ],
)  # fmt: skip
def test_a_straight_behind_a_joint_that_is_too_short_is_reported(
    tmp_path: Path, segments: str, room: str
) -> None:
    pipe = (
        "{section: round, diameter: 120 mm, start: {at: 700 mm},"
        f" segments: [{{straight: 1 m}}, {segments}]}}"
    )

    missed = found(tmp_path, FIRST, pipe)

    assert [each.code for each in missed] == ["geometry.too_short"] * bool(room)
    for each in missed:
        assert f"there are {room} of straight walls here" in each.message


# --- forces -------------------------------------------------------------------------------------

SLIPPERY = ", friction: {static: 0.12, kinetic: 0.1}"


@pytest.mark.parametrize(
    ("rest", "do", "weak"),
    [
        (SLIPPERY, FIRST, True),  # the leg behind the bend climbs
        (SLIPPERY, "ClampFront, ClampRear, RelaxFront", False),  # the first lies flat
        (SLIPPERY + ", frame: {pitch: 90 deg}", "ClampFront, ClampRear, RelaxFront", True),
        (SLIPPERY + ", frame: {roll: -90 deg}", FIRST, False),  # it lies on its side
        (", frame: {pitch: 90 deg}", FIRST, False),
    ],
)
def test_each_run_has_the_slope_of_its_own_frame(
    tmp_path: Path, rest: str, do: str, weak: bool
) -> None:
    missed = found(tmp_path, do, space(UP, start="at: 700 mm, roll: 90 deg", rest=rest))

    assert [each.code for each in missed] == ["geometry.clamp_torque"] * weak


def test_a_part_presses_by_the_diameter_of_the_piece_in_which_it_stands(tmp_path: Path) -> None:
    narrow = "{reducer: 60 mm, to: 80 mm}"
    up = ", frame: {pitch: 90 deg}, friction: {static: 0.01, kinetic: 0.01}"
    hold = "ClampFront, ClampRear, RelaxFront"

    (wide,) = found(tmp_path, hold, space(narrow, rest=up))
    (before,) = found(tmp_path, hold, space(narrow, start="at: 1.8 m", rest=up))

    # 4 * 0.707 Nm / sqrt(90² - h²) mm (eq. 3-3), h = 72 mm and 32 mm
    assert "press the walls with 52.4 N" in wide.message
    assert "press the walls with 33.6 N" in before.message
