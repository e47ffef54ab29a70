"""Frames that the simulator takes for the engine change nothing that the engine would not change.

Every effect comes at the same time, with the same state of the engine to the last bit of every
signal, and the robot ends where it would have ended.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from random import Random

import pytest
from representative import thorough_but

from agreement.missions import invent
from agreement.robots import NEWT, PIRATE
from agreement.stepping import Kept, Places, assert_the_same, course
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.running.wiring import Order

IN_PLANE = ("climb", "enter_2d", "enter_3d", "inspect", "mitre_bend", "take_bend")
ROUND = ("level", "take_branch", "take_elbow", "turn_left")
QUICK = (*IN_PLANE, *ROUND)
FEW = ("climb", "enter_3d", "mitre_bend")
SHIPPED = [path.stem for path in library.missions()]
DEFECTS = sorted(load_robot(library.find_robot("pirate_ii")).profile.simulation.defects)
TIMED = (
    "wheel_2_dead:after=5s",
    "gamma_2_stiff:friction=0.4Nm,after=3s..9s",
    "board_23_silent:after=7s",
    "front_wheels_stick:after=4s,lasting=1s",
    "gamma_4_zero_jumps:by=-8deg,after=6s",
    "messages_lost:after=5s",
    "gamma_1_sticks:after=3s,lasting=2s,every=2s",
    "board_24_silent:after=2s,lasting=50ms,every=300ms",
)
DETECTORS = ("sim", "odometry")
PIPES_OF_PIRATE = ("mitre_90", "elbow_90", "mitre_90_round")
SOMEWHERE = {"start_jitter_m": 0.02, "friction_jitter": 0.2, "diameter_jitter_m": 0.002}

pytestmark = pytest.mark.timeout(300)  # the first run compiles


def test_most_frames_are_taken_for_the_engine() -> None:
    taken = assert_the_same(Order("mitre_bend"))

    assert taken > 4130  # of 4235


@pytest.mark.thorough
def test_most_frames_are_taken_while_a_report_from_outside_counts() -> None:
    taken = assert_the_same(Order("mitre_bend", detector="odometry"))

    assert taken > 4105  # of 4206


def test_frames_are_taken_while_declared_states_are_compared_with_sensors() -> None:
    assert assert_the_same(Order("climb"), after_s=0.5) > 15  # of 34


def test_frames_of_other_boards_are_taken_while_a_sensor_is_not_believed() -> None:
    order = Order("mitre_bend", seed=3, defects=("gamma_4_zero_jumps:by=-8deg,after=6s",))

    assert assert_the_same(order, after_s=12.0) > 360  # 337 while each of them went to the engine


@pytest.mark.thorough
@pytest.mark.parametrize(("mission", "most"), [
    ("turn_left", 1150), ("turn_right", 1150),  # of 1340
])  # fmt: skip
def test_most_frames_are_taken_in_a_round_pipe(mission: str, most: int) -> None:
    assert assert_the_same(Order(mission)) > most


def test_a_recording_of_blocks_has_every_step() -> None:
    glided, stepped, order = Kept(), Kept(), Order("mitre_bend")
    _, taken = course(order, glides=True, tap=glided)
    course(order, glides=False, tap=stepped)

    assert taken > 1600
    assert 0 < glided.blocks < 300
    assert glided.steps == stepped.steps


@pytest.mark.parametrize("mission", thorough_but(["climb"], ["mitre_bend", "climb", "take_elbow"]))
def test_where_the_robot_was_is_known_at_every_step(mission: str) -> None:
    glided, stepped, order = Places(), Places(), Order(mission)
    course(order, glides=True, tap=glided)
    course(order, glides=False, tap=stepped)

    assert glided.blocks > 0
    assert glided.places == stepped.places


def test_a_tap_that_looks_at_every_step_sees_every_step() -> None:
    tap = Kept()
    tap.stepwise = True

    assert course(Order("enter_2d"), glides=True, tap=tap)[1] == 0


@pytest.mark.parametrize("mission", [
    *thorough_but(FEW, QUICK),
    *(pytest.param(name, marks=pytest.mark.slow) for name in SHIPPED if name not in QUICK),
])  # fmt: skip
def test_shipped_missions(mission: str) -> None:
    assert_the_same(Order(mission))


@pytest.mark.parametrize("detector", thorough_but(DETECTORS[:1], DETECTORS))
@pytest.mark.parametrize("seed", [
    1, pytest.param(2, marks=pytest.mark.thorough),
    *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 13)),
])  # fmt: skip
def test_robots_that_start_somewhere(seed: int, detector: str) -> None:
    mission = ("mitre_bend", "take_bend", "take_elbow", "take_branch")[seed % 4]
    assert_the_same(Order(mission, seed=seed, detector=detector, **SOMEWHERE))


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("defect", DEFECTS)
@pytest.mark.parametrize("mission", ["mitre_bend", "take_elbow"])
@pytest.mark.slow
def test_robots_with_a_defect(mission: str, defect: str, detector: str) -> None:
    assert_the_same(Order(mission, seed=3, defects=(defect,), detector=detector))


@pytest.mark.thorough
def test_robots_with_two_defects() -> None:
    lot = Random(5)
    for seed in range(3):
        defects = tuple(lot.sample(DEFECTS, 2))
        for mission in ("mitre_bend", "take_elbow"):
            assert_the_same(Order(mission, seed=seed, defects=defects), after_s=12.0)


@pytest.mark.parametrize("defect", thorough_but(TIMED[2:6], TIMED))
def test_belief_meets_a_defect_that_begins_while_frames_are_taken(defect: str) -> None:
    mission = ("mitre_bend", "take_elbow")[TIMED.index(defect) % 2]
    order = Order(mission, seed=3, defects=(defect,), detector="odometry")

    assert assert_the_same(order, after_s=12.0) > 50


def test_a_mission_that_reads_the_distance_glides_between_two_judgements_of_it() -> None:
    assert assert_the_same(Order("climb")) > 1640  # of 1754


def test_the_distance_is_the_same_in_a_glide_where_a_wheel_is_not_believed() -> None:
    order = Order("climb", defects=("wheel_2_dead",), detector="odometry")

    assert assert_the_same(order, after_s=12.0) > 50


@pytest.mark.parametrize("defect", ["gamma_2_stiff", "gamma_2_sticks"])
@pytest.mark.parametrize("mission", thorough_but(["mitre_bend"], ["mitre_bend", "take_elbow"]))
def test_defects_of_motors_and_of_values_let_frames_be_taken(mission: str, defect: str) -> None:
    order = Order(mission, defects=(defect,))

    assert assert_the_same(order, after_s=8.0) > 200


FITTINGS = {
    "mitre": "{mitre: 90 deg}",
    "elbow": "{elbow: 90 deg, radius: 180 mm}",
    "branch": "{tee: 90 deg, take: branch, diameter: 120 mm}",
    "on": "{tee: 90 deg, take: on, roll: 90 deg, diameter: 120 mm}",
    "reducer": "{reducer: 60 mm, to: 105 mm}",
    "step": "{reducer: 0 mm, to: 110 mm}",
}


@pytest.mark.parametrize("pitch", ["0 deg", "60 deg", "-90 deg"])
@pytest.mark.parametrize("fitting", [
    pytest.param(name, marks=() if name == "reducer" else pytest.mark.slow) for name in FITTINGS
])  # fmt: skip
def test_fittings_of_round_pipes(fitting: str, pitch: str, tmp_path: Path) -> None:
    pipe = round_pipe(tmp_path, f"{{straight: 1 m}}, {FITTINGS[fitting]}, {{straight: 1 m}}", pitch)
    mission = {"elbow": "take_elbow", "mitre": "take_bend", "branch": "take_branch"}

    order = Order(mission.get(fitting, "drive_on"), pipe=pipe, seed=5, **SOMEWHERE)

    taken = assert_the_same(order, after_s=40.0)

    assert taken > 100 or order.mission == "drive_on"  # which reads the distance


def test_a_robot_that_drives_out_of_a_round_pipe(tmp_path: Path) -> None:
    steps = ("ClampFront", "ClampRear", "DriveForward")
    pipe = round_pipe(tmp_path, "{straight: 1 m}", "0 deg")
    order = Order(lasting(tmp_path, steps), pipe=pipe)

    assert "gone=True" in course(order, glides=True)[0][-1]
    assert assert_the_same(order) > 500


@pytest.mark.parametrize("pitch", ["-60 deg", "90 deg"])
def test_a_robot_that_falls_through_a_round_pipe(pitch: str, tmp_path: Path) -> None:
    pipe = round_pipe(tmp_path, "{straight: 1 m}", pitch)
    order = Order(lasting(tmp_path, ()), pipe=pipe)

    assert "robot.fallen" in course(order, glides=True)[0][-1]
    assert_the_same(order)


def round_pipe(folder: Path, segments: str, pitch: str) -> str:
    """A round pipe with both ends open, in a file."""
    path = folder / "fitting.yaml"
    path.write_text(
        "format: 1\npipe: fitting\nsection: round\ndiameter: 120 mm\nstart: {at: 700 mm}\n"
        f"frame: {{pitch: {pitch}}}\nsegments: [{segments}]\n",
        encoding="utf-8",
    )
    return str(path)


def lasting(folder: Path, steps: Sequence[str]) -> str:
    """A mission that commands this and then minds nothing for 25 seconds, in a file."""
    mission = {
        "format": 1, "mission": "lasting", "robot": "pirate_ii", "start": "go",
        "on_fault": [{"fault": ["robot.stuck", "clamp.lost"], "then": "continue"}],
        "phases": {"go": {"do": [*steps], "wait": [{"after": "25 s", "go": "over"}]}},
        "ends": {"over": {"succeed": "Time is over"}},
    }  # fmt: skip
    path = folder / "lasting.yaml"
    path.write_text(json.dumps(mission), encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("first", [
    0, *(pytest.param(first, marks=pytest.mark.slow) for first in range(10, 100, 10))
])  # fmt: skip
def test_missions_that_nobody_wrote(first: int) -> None:
    for seed in range(first, first + 10):
        invented = invent(seed, ("pirate", "newt", "made"))
        pipe = PIPES_OF_PIRATE[seed % 3]
        if invented.words.path != PIRATE:
            pipe = str(NEWT / ("elbow.yaml", "round.yaml")[seed % 2])
        order = Order(str(invented.write()), pipe=pipe, seed=seed, **SOMEWHERE)
        assert_the_same(order, after_s=6.0)
