"""The shipped missions: they succeed, in the order of the thesis, and never let go."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import pytest
from representative import MISSIONS, thorough_but

from pirate_sm.core import library
from pirate_sm.core.documents import LoadError
from pirate_sm.core.effects import CommandStatus, Fault, StateChange
from pirate_sm.core.loading import load_mission

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = library.missions()
DRIVEN = thorough_but(
    [path for path in SHIPPED if path.stem in {*MISSIONS, "two_bends_up"}],
    SHIPPED,
)
PRINTED = Path(__file__).parent / "enter_3d_as_printed.yaml"

# Fig. 6-9 of the thesis: FrontWheels, RearWheels, Bending, Rotation, Lighting.
FIG_6_9 = [
    ("Free", "Free", "Unclamped", "Unaligned", "Off"),
    ("Free", "Fixed", "RearClampedFrontRelaxed", "Unaligned", "On"),
    ("Free", "Fixed", "RearClampedFrontBending", "Unaligned", "On"),
    ("Free", "DrivingForward", "RearClampedFrontBending", "Unaligned", "On"),
    ("Free", "Fixed", "RearClampedFrontBending", "Unaligned", "On"),
    ("Fixed", "Fixed", "DoubleClamped", "Unaligned", "On"),
    ("Fixed", "Fixed", "FrontClampedRearBendingBack", "Unaligned", "On"),
    ("DrivingForward", "DrivingForward", "DoubleClamped", "Unaligned", "On"),
    ("Fixed", "Fixed", "DoubleClamped", "Unaligned", "On"),
]
_TURNED = {"Front": "Rear", "Rear": "Front", "Forward": "Backward"}


def _reversed(states):
    """The same moment with front and rear exchanged and the direction turned."""
    front, rear, *rest = states
    return tuple(
        re.sub("Front|Rear|Forward", lambda match: _TURNED[match[0]], word)
        for word in (rear, front, *rest)
    )


def _contains(trace, wanted):
    rest = iter(trace)
    return all(each in rest for each in wanted)


@pytest.mark.parametrize("path", DRIVEN, ids=lambda path: path.stem)
def test_a_shipped_mission_succeeds_in_a_trace(run, path):
    record = run(path, backend="trace")
    assert record.ended.outcome == "succeeded", record.ended.message


@pytest.mark.parametrize("path", DRIVEN, ids=lambda path: path.stem)
def test_a_shipped_mission_succeeds_never_lets_go_and_ends_with_stopped_wheels(run, path):
    record = run(path, backend="sim")
    assert record.ended.outcome == "succeeded", record.ended.message
    held = [change.states[2] != "Unclamped" for change in record.of(StateChange)]
    assert held == sorted(held)
    assert {record.last_setpoints[f"wheel_{number}"] for number in range(1, 7)} == {0.0}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_mission_is_found_by_its_name_and_says_what_it_does(path):
    assert library.find_mission(path.stem) == path
    text = path.read_text("utf-8")
    assert f"\nmission: {path.stem}\n" in text
    assert "\ndescription: " in text


@pytest.mark.parametrize("backend", ["trace", "sim"])
@pytest.mark.parametrize(
    "mission",
    thorough_but(["exp_2a_commands"], ["mitre_bend", "exp_2a_commands", "exp_2b_detector"]),
)
def test_the_bend_shows_the_nine_snapshots(run, mission, backend):
    assert _contains(run(mission, backend=backend).states, FIG_6_9)


def test_the_bend_backward_shows_them_with_front_and_rear_exchanged(run):
    record = run("mitre_bend_backward", backend="sim")
    assert _contains(record.states, [_reversed(states) for states in FIG_6_9])
    assert record.prepared.truth().distance_m < -0.6


@pytest.mark.parametrize(
    "name", thorough_but(["exp_1a_both"], ["exp_1a_both", "exp_1b_front", "exp_1c_rear"])
)
def test_experiment_1_goes_up_and_down_three_times_and_meets_a_block_each_way(run, name):
    fired = run(name, backend="sim").fired
    assert [trigger for trigger in fired if trigger.endswith("_end")] == ["far_end", "near_end"] * 3
    second = fired[fired.index("near_end") + 1 :]
    assert second[:6] == ["blocked", "free", "far_end", "blocked", "free", "near_end"]


def test_climbing_holds_its_place(run):
    record = run("climb", backend="sim")
    assert record.fired == ["at_height", "held", "at_the_start"]
    assert record.prepared.truth().distance_m == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("seed", thorough_but([0], range(20)))
def test_entering_in_3d_turns_both_parts_from_upright_into_the_horizontal_plane(run, seed):
    record = run(
        "enter_3d", backend="sim", seed=seed,
        start_jitter_m=0.02, friction_jitter=0.2, diameter_jitter_m=0.002,
    )  # fmt: skip
    assert record.ended.outcome == "succeeded", record.ended.message
    # The pipe is rolled by -90 deg against the robot: it began with both parts at +90 deg.
    assert record.prepared.loaded.pipe.roll == pytest.approx(-math.pi / 2)
    assert record.prepared.truth().rolls_rad == pytest.approx((0.0, 0.0, 0.0), abs=0.06)
    assert ("Free", "Fixed", "RearClampedFrontRelaxed", "AlignedLeft", "On") in record.states
    assert record.states[-1][2:] == ("DoubleClamped", "AlignedStraight", "On")


def test_entering_in_3d_with_the_wrong_side_below_ends_holding_with_the_reason(run, tmp_path):
    text = library.find_pipe("straight_113_upright").read_text("utf-8")
    pipe = tmp_path / "other_way_up.yaml"
    pipe.write_text(text.replace("roll: -90 deg", "roll: 90 deg"), "utf-8")
    record = run("enter_3d", backend="sim", pipe=str(pipe))
    assert (record.ended.outcome, record.ended.end) == ("failed", "not_level")
    assert record.ended.message.startswith("Holding, both parts clamped")
    assert record.states[-1][2] == "DoubleClamped"


UPRIGHT = """\
format: 1
mission: upright
robot: pirate_ii
pipe: {diameter: 120 mm, tilt: 90 deg, segments: [{straight: 5 m}], start: {at: 600 mm}}
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: turn
phases:
  turn:
    do: [RelaxFront, AlignRight, ClampFront, RelaxRear, AlignStraight, ClampRear]
    go: turn_on_the_way
  turn_on_the_way:
    do: [RelaxFront, DriveForward, AlignLeft, Brake, ClampFront]
    go: turned
ends: {turned: {succeed: Turned}}
"""


@pytest.mark.parametrize("seed", thorough_but([0], range(4)))
def test_in_a_vertical_pipe_the_robot_turns_without_falling_also_while_it_climbs(
    run, tmp_path, seed
):
    mission = tmp_path / "upright.yaml"
    mission.write_text(UPRIGHT, "utf-8")
    record = run(mission, backend="sim", seed=seed, friction_jitter=0.2, diameter_jitter_m=0.002)
    assert record.ended.outcome == "succeeded", record.ended.message
    turned = (-math.pi / 2, 0.0, math.pi / 2)
    assert record.prepared.truth().rolls_rad == pytest.approx(turned, abs=0.06)
    assert record.prepared.truth().distance_m > 0.3


def test_without_the_posture_the_part_that_was_clamped_does_not_turn(run, tmp_path):
    robot = tmp_path / "unprepared"
    shutil.copytree(ROOT / "hardware_profiles" / "pirate_ii", robot)
    profile = robot / "profile.yaml"
    profile.write_text(profile.read_text("utf-8").replace("    posture: slack\n", ""), "utf-8")
    record = run("enter_3d", backend="sim", robot=str(robot))
    # The front was loose and turned; the rear was clamped and is only relaxed by duty 0.
    assert re.search(r"AlignStraight .* failed: not done within 40 s", record.ended.message)
    turned = (-math.pi / 2, 0.0, math.pi / 2)
    assert record.prepared.truth().rolls_rad == pytest.approx(turned, abs=1e-3)


def test_entering_in_3d_as_printed_is_refused():
    with pytest.raises(LoadError, match="AlignLeft or AlignRight") as caught:
        load_mission(PRINTED)
    assert "enter_3d_as_printed.yaml:" in str(caught.value)


@pytest.mark.parametrize(
    ("struck_out", "command", "reason"),
    [
        (("AlignOther",), "ClampRear", "unneeded"),
        (("ToggleLight", "ClampRear", "AlignOther"), "RelaxRear", "impossible"),
    ],
)
def test_what_else_is_wrong_with_it_is_refused_when_it_runs(
    run, tmp_path, struck_out, command, reason
):
    lines = PRINTED.read_text("utf-8").splitlines()
    for name in struck_out:
        last = max(number for number, line in enumerate(lines) if line.strip() == f"- {name}")
        del lines[last]
    mission = tmp_path / "printed.yaml"
    mission.write_text("\n".join(lines), encoding="utf-8")
    refused = [s for s in run(mission, backend="trace").of(CommandStatus) if s.status == "refused"]
    assert [(status.name, status.reason.split(":")[0]) for status in refused] == [(command, reason)]


def _changed(tmp_path, pipe, **keys):
    """A shipped pipe's file with lines added, for what the pipes do not show by themselves."""
    text = library.find_pipe(pipe).read_text("utf-8")
    path = tmp_path / "changed.yaml"
    path.write_text(text + "".join(f"{key}: {value}\n" for key, value in keys.items()), "utf-8")
    return str(path)


@pytest.mark.parametrize(
    "mission",
    thorough_but(["mitre_bend"], ["mitre_bend", "exp_2a_commands", "exp_2b_detector"]),
)
def test_a_stuck_robot_ends_clamped_and_says_so(run, tmp_path, mission):
    pipe = _changed(tmp_path, "mitre_90", blockages="[{at: 850 mm, lasting: 1 h}]")
    record = run(mission, backend="sim", pipe=pipe)
    assert record.ended.outcome == "failed"
    assert "both parts clamped, after robot.stuck" in record.ended.message
    assert record.states[-1][:3] == ("Fixed", "Fixed", "DoubleClamped")


@pytest.mark.parametrize("seed", thorough_but([2], range(3)))
def test_a_stuck_robot_that_opens_to_118_deg_has_not_lost_its_clamp(run, tmp_path, seed):
    pipe = _changed(tmp_path, "mitre_90", blockages="[{at: 850 mm, lasting: 1 h}]")
    record = run("mitre_bend", backend="sim", pipe=pipe, seed=seed)
    assert {fault.code for fault in record.of(Fault)} == {"robot.stuck"}


DOWN = """
format: 1
mission: down
robot: pirate_ii
pipe: vertical
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: down
phases:
  down:
    do: [DriveBackward]
    wait: [{when: odometry <= -1 m, go: halt}]
    within: {time: 60 s, go: halt}
  halt: {do: [Brake], go: there}
ends:
  there: {succeed: Driven down}
"""


def test_a_falling_robot_is_noticed_and_keeps_its_clamps(run, tmp_path):
    pipe = Path(
        _changed(
            tmp_path, "vertical", patches="[{from: 0 m, to: 1.1 m, static: 0.04, kinetic: 0.02}]"
        )
    )
    pipe.write_text(pipe.read_text("utf-8").replace("at: 600 mm", "at: 1.5 m"), "utf-8")
    mission = tmp_path / "down.yaml"
    mission.write_text(DOWN, "utf-8")
    record = run(mission, backend="sim", pipe=str(pipe))
    assert record.ended.outcome == "fault"
    assert "robot.fallen" in record.ended.message
    clamps = [record.last_setpoints[f"bend_{number}"] for number in range(1, 5)]
    assert [clamp > 0 for clamp in clamps] == [False, True, False, True]


@pytest.mark.parametrize(
    ("quick", "later"),
    thorough_but(
        [(True, "motion.unasked")], [(True, "motion.unasked"), (False, "distance.unknown")]
    ),
)
def test_a_robot_whose_wheels_spin_at_the_edge_of_a_slippery_stretch_does_not_fall(
    run, tmp_path, assumed_speeds, quick, later
):
    pipe = _changed(
        tmp_path, "vertical", patches="[{from: 500 mm, to: 2 m, static: 0.04, kinetic: 0.02}]"
    )
    twin = {"twin": assumed_speeds} if quick else {}
    record = run("climb", backend="sim", pipe=pipe, **twin)
    assert "robot.fallen" not in {fault.code for fault in record.of(Fault)}
    assert record.ended.message.startswith(later)  # beyond the lower end
    clamps = [record.last_setpoints[f"bend_{number}"] for number in range(1, 5)]
    assert [clamp > 0 for clamp in clamps] == [False, True, False, True]


@pytest.mark.parametrize("seed", thorough_but([0], range(8)))
@pytest.mark.parametrize("mission", ["climb", "mitre_bend"])
def test_boards_that_repeat_their_values_for_a_tenth_of_a_second_stop_no_mission(
    run, mission, seed
):
    """Section 5-5 of the thesis reports this of the real robot."""
    record = run(mission, backend="sim", seed=seed, defects=("stale_repeats",))
    assert record.ended.outcome == "succeeded", record.ended.message


def test_the_bend_mission_ends_where_there_is_no_bend(run, tmp_path):
    text = library.find_pipe("straight_113").read_text("utf-8")
    pipe = tmp_path / "longer.yaml"
    pipe.write_text(text.replace("1.135 m", "2 m"), "utf-8")
    record = run("mitre_bend", backend="sim", pipe=str(pipe), settings={"give_up": "5 s"})
    assert record.ended.end == "not_found"
    assert record.states[-1][2] == "DoubleClamped"


def test_a_part_that_has_left_the_pipe_stops_the_robot(run):
    record = run("mitre_bend", backend="sim", pipe="straight_113")
    assert record.ended.end == "no_wall"
    assert "clamp.lost" in record.ended.message


def test_from_a_phase_on(run):
    states = {
        "BendingState": "DoubleClamped", "FrontWheelsState": "DrivingForward",
        "RearWheelsState": "DrivingForward", "LightingState": "On",
    }  # fmt: skip
    record = run("mitre_bend", backend="trace", start_phase="prepare", states=states)
    assert _contains(record.states, FIG_6_9[1:])
