"""What missions claim by a distance is so, or lies within the bound that they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.belief import judged
from benchmarks.belief_cases import WAYS, Case
from pirate_sm.core.effects import Fault
from pirate_sm.running.wiring import Order

STEP = """\
format: 1
pipe: step
section: round
diameter: 120 mm
segments: [{straight: 1.2 m}, {reducer: 1 mm, to: 110 mm}, {straight: 1.8 m}]
start: {at: 1 m}
friction: {static: 0.1, kinetic: 0.07}
"""
ICE = """\
format: 1
pipe: ice
section: round
diameter: 120 mm
frame: {pitch: 90 deg}
segments: [{straight: 3 m}]
start: {at: 1.2 m}
patches: [{from: 1.25 m, to: 1.6 m, static: 0.05, kinetic: 0.036}]
"""


WIDER = """\
format: 1
pipe: wider
section: round
diameter: 115 mm
frame: {pitch: 0 deg}
segments: [{straight: 1.269 m}, {reducer: 43 mm, to: 118 mm}, {straight: 1.931 m}]
start: {at: 1 m}
friction: {static: 0.843, kinetic: 0.786}
"""


ROUND = """\
format: 1
pipe: round
section: round
diameter: 120 mm
segments: [{straight: 3 m}]
start: {at: 1 m}
"""


UPRIGHT = """\
format: 1
pipe: upright
section: round
diameter: 120 mm
frame: {pitch: 90 deg}
segments: [{straight: 3 m}]
start: {at: 1.2 m}
friction: {static: 0.23, kinetic: 0.184}
"""


DRY = """\
format: 1
pipe: dry
diameter: 120 mm
segments: [{straight: 1.135 m}]
start: {at: 500 mm}
friction: {static: 0.478, kinetic: 0.429}
"""


def shown(record) -> tuple[float, float, float]:
    """What the odometer shows, its bound, and how far the robot is from it, in mm.

    The robot has not moved before it drove.
    """
    state, robot = record.state, record.prepared.engine.robot
    odometry, bound = (state.sensing.numbers[at] for at in (robot.odometry, robot.bound))
    true_m = record.prepared.truth().distance_m
    return odometry * 1000, bound * 1000, abs(odometry - true_m) * 1000


@pytest.mark.parametrize("defects", [
    ("wheels_3_4_dead",), ("wheels_3_4_dead:after=2s",), ("wheel_5_dead:after=1.5s",),
    ("front_wheels_dead",), ("front_wheels_stick",),
])  # fmt: skip
def test_belief_in_wheels_that_are_dead_ends_with_the_way_that_they_lack(run, defects) -> None:
    record = run("drive_on", settings={"way": "400 mm"}, defects=defects)

    _, bound_mm, off_mm = shown(record)
    assert off_mm < min(20, bound_mm)


def test_belief_in_the_mean_of_the_wheels_ends_where_dead_ones_are_dragged(tmp_path: Path) -> None:
    """One of three wheels slipped where the others rolled: it said 18 ± 27 mm at -13 mm."""
    pipe = tmp_path / "dry.yaml"
    pipe.write_text(DRY, encoding="utf-8")
    order = Order(
        "exp_1a_both",
        pipe=str(pipe),
        settings={"far": "381 mm"},
        seed=1940,
        start_jitter_m=0.02,
        defects=("rear_wheels_dead:friction=0.108Nm",),
    )

    found = judged(Case(1940, "one defect", WAYS[14], order, None, 2.286))

    assert found.verdict == "claimed"
    assert 0.02 < abs(found.claim.estimate_m - found.claim.truth_m) < found.claim.bound_m


def test_belief_in_a_distance_has_a_narrow_bound_where_nothing_is_wrong(run) -> None:
    record = run("climb")

    _, bound_mm, off_mm = shown(record)
    assert record.ended.outcome == "succeeded"
    assert off_mm < 5 < bound_mm < 10 + 0.02 * 1000


@pytest.mark.parametrize("pipe", [STEP, ICE])
@pytest.mark.parametrize("mission", ["drive_on", "climb"])
def test_belief_in_wheels_ends_where_they_may_slip(
    run, tmp_path: Path, pipe: str, mission: str
) -> None:
    (tmp_path / "slippery.yaml").write_text(pipe, encoding="utf-8")
    record = run(mission, pipe=str(tmp_path / "slippery.yaml"))

    _, bound_mm, off_mm = shown(record)
    codes = [fault.code for fault in record.of(Fault)]
    assert record.ended.outcome != "succeeded"
    assert {"distance.unknown", "robot.stuck", "robot.fallen"} & set(codes)
    assert off_mm < bound_mm or "robot.fallen" in codes


def test_belief_in_wheels_ends_where_they_run_on_the_sides_of_their_tyres(tmp_path: Path) -> None:
    """It clamped above the axis of the pipe, and said 419 ± 19 mm at 392 mm."""
    pipe = tmp_path / "wider.yaml"
    pipe.write_text(WIDER, encoding="utf-8")
    order = Order(
        "enter_2d", pipe=str(pipe), settings={"way": "416 mm"}, seed=238, start_jitter_m=0.02
    )

    claim = judged(Case(238, "pipe", WAYS[4], order, None, 0.416)).claim

    assert abs(claim.estimate_m - claim.truth_m) < 0.012 < claim.bound_m < 0.03


def test_wheels_off_the_axis_lack_no_more_than_the_edges_of_their_tyres(tmp_path: Path) -> None:
    """It clamped 18 mm off the axis, and said 106 mm at 111 mm."""
    pipe = tmp_path / "round.yaml"
    pipe.write_text(ROUND, encoding="utf-8")
    order = Order("enter_2d", pipe=str(pipe), settings={"way": "100 mm"}, seed=3)

    claim = judged(Case(3, "nothing", WAYS[4], order, None, 0.1)).claim

    assert abs(claim.estimate_m - claim.truth_m) < 0.02 * claim.truth_m < claim.bound_m


def test_belief_in_wheels_that_are_kept_at_one_speed_ends_while_they_drag_dead_ones(
    run, tmp_path: Path
) -> None:
    """Their loops let slipping wheels turn alike: it said 605 ± 518 mm at 1 mm."""
    mission, pipe = tmp_path / "asking.yaml", tmp_path / "upright.yaml"
    kept = ASKING.replace("start: drive", "control: exp_3a\nstart: drive")
    handled = "[distance.unknown, wheel.dead, robot.stuck, sensor.silent], then: continue"
    kept = kept.replace("distance.unknown, go: halt", handled).replace("400", "600")
    mission.write_text(kept, encoding="utf-8")
    pipe.write_text(UPRIGHT, encoding="utf-8")

    record = run(mission, pipe=str(pipe), seed=3, defects=("wheels_3_4_dead",))

    odometry_mm, bound_mm, off_mm = shown(record)
    assert odometry_mm > 600
    assert 500 < off_mm < bound_mm


def test_a_wait_asks_for_a_bound_of_its_own(run, tmp_path: Path) -> None:
    mission = tmp_path / "asking.yaml"
    mission.write_text(ASKING, encoding="utf-8")

    wide, narrow = (run(mission, settings={"bound": bound}) for bound in ("20 mm", "6 mm"))

    assert wide.ended.outcome == "succeeded"
    assert narrow.ended.message.startswith("Not known: distance.unknown: the wheels show 40")
    assert "must be known within 6 mm" in narrow.ended.message


@pytest.mark.parametrize("mission", ["drive_on", pytest.param("climb", marks=pytest.mark.thorough)])
def test_tyres_that_resist_rolling_do_not_slip_while_they_drag_dead_wheels(
    run, mission: str
) -> None:
    resisting = {"tyre.rolling_resistance": "0.02"}

    ended = run(mission, defects=("wheels_3_4_dead",), numbers=resisting).ended

    assert ended.outcome == "succeeded", ended.message


def test_belief_in_a_distance_that_fails_at_the_end_leads_to_its_handler(
    run, tmp_path: Path
) -> None:
    mission, pipe = tmp_path / "asking.yaml", tmp_path / "slippery.yaml"
    mission.write_text(ASKING.replace("known within $bound", ""), encoding="utf-8")
    pipe.write_text(STEP, encoding="utf-8")

    ended = run(mission, pipe=str(pipe), settings={"bound": "1 m"}).ended

    assert ended.outcome == "failed"
    assert ended.message.startswith("Not known: distance.unknown")


ASKING = """\
format: 1
mission: asking
robot: pirate_ii
pipe: straight_round
parameters:
  bound: {type: length, default: 20 mm, description: How well the way must be known}
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
on_fault: [{fault: distance.unknown, go: halt}]
start: drive
phases:
  drive:
    do: [DriveForward]
    wait: [{when: change(odometry) >= 400 mm known within $bound, go: stop}]
    within: {time: 20 s, go: halt}
  stop: {do: [Brake], go: there}
  halt: {do: [{command: Brake, unneeded: skip, on_failure: continue}], go: unknown}
ends:
  there: {succeed: There}
  unknown: {fail: "Not known: {cause}"}
"""
