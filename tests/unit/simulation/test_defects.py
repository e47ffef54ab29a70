from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Defect, Profile
from pirate_sm.simulation.acting_defect import ActingDefect
from pirate_sm.simulation.defects import drawn, named, put_to_work
from pirate_sm.simulation.kinematic import columns

from .conftest import CYCLE_S, Driver, straight

Place = Callable[..., Driver]


def effect(robot: Driver, kind: str, **numbers: Any) -> ActingDefect:
    defect = Defect(kind=kind, description="", **numbers)  # type: ignore[arg-type]
    (made,) = put_to_work([(defect, np.random.default_rng(3))], robot.electronics)
    return made


def shown(robot: Driver, made: ActingDefect, now: float, name: str) -> float | None:
    """The count that a signal's channel shows; None when no frame comes."""
    row = robot.electronics.rows[name]
    board = next(b for b in robot.electronics.boards if b.first <= row < b.last)
    counts = made.frame(now, board.board, board.first, robot.read()[board.first : board.last])
    return None if counts is None else counts[row - board.first]


def test_a_dead_wheel_drags_as_the_profile_says_of_its_motor(place: Place) -> None:
    robot = place(straight())
    effect(robot, "dead_wheel", wheels=("wheel_3",))
    drag = robot.chain.wheels[2].dead_drag_nm
    assert drag == pytest.approx(0.05)
    assert robot.physics.body[2, columns.WHEEL_HOLD] == drag


def test_a_dead_wheel_drags_and_shows_nothing(place: Place) -> None:
    robot, whole = place(straight()), place(straight())
    made = effect(robot, "dead_wheel", wheels=("wheel_3",), friction=0.1)
    for each in (robot, whole):
        each.clamp(1, 2, 3, 4)
        each.drive(1.0)
        each.run(3.0)
    assert shown(robot, made, 3.0, "theta_3") == 0.0
    assert shown(robot, made, 3.0, "theta_4") != 0.0
    assert 0.0 < robot.middle - 0.73 < whole.middle - 0.73


def test_a_stiff_joint_needs_more_torque(place: Place) -> None:
    robot, whole = (place(straight(), clamped=0.0) for _ in range(2))
    effect(robot, "stiff_joint", joint="gamma_2", friction=0.9)
    for each in (robot, whole):
        each.physics.duties[2] = 0.7
        each.run(2.0)
    assert whole.values("bend")[2] > 0.3
    assert abs(robot.values("bend")[2]) < 0.05


@pytest.mark.parametrize("kind", ["sensor_stuck", "sensor_drop", "sensor_spike"])
def test_a_sensor_shows_its_wrong_count_for_a_while(place: Place, kind: str) -> None:
    robot = place(straight())
    made = effect(robot, kind, raw={"gamma_3": -1707}, after=1.0, lasting=0.5)
    times = [0.1 * i for i in range(30)]
    wrong = [t for t in times if shown(robot, made, t, "gamma_3") == -1707]
    assert min(wrong) == pytest.approx(1.0)
    assert max(wrong) == pytest.approx(1.4, abs=0.11)


def test_spikes_come_again_at_random(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "sensor_spike", raw={"gamma_3": -1707}, every=2.0, lasting=0.05)
    wrong = [shown(robot, made, 0.02 * i, "gamma_3") == -1707 for i in range(3000)]
    starts = sum(1 for a, b in itertools.pairwise(wrong) if b and not a)
    assert 15 < starts < 50
    assert not wrong[0]


def test_a_sensor_may_stick_where_it_was(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    made = effect(robot, "sensor_stuck", signals=("gamma_1",), after=0.5)
    robot.physics.duties[1] = -0.5
    robot.run(0.5)
    first = shown(robot, made, 0.6, "gamma_1")
    robot.run(2.0)
    assert shown(robot, made, 3.0, "gamma_1") == first
    assert robot.electronics.counts[robot.electronics.rows["gamma_1"]] != first


def test_a_zero_jumps_once(place: Place) -> None:
    robot = place(straight())
    row = robot.electronics.rows["gamma_1"]
    made = effect(robot, "zero_jump", raw={"gamma_1": 500}, after=1.0)
    before = robot.read()[row]
    for now in (0.5, 1.0, 1.5):
        made.step(now)
    assert robot.read()[row] - before == pytest.approx(500, abs=10)


def test_a_silent_bay_says_nothing_takes_nothing_and_moves(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "silent_bay", after=1.0)
    assert made.delivery(0.5) == (True, True)
    assert shown(robot, made, 0.5, "gamma_1") is not None
    assert shown(robot, made, 1.5, "gamma_1") is None
    assert made.delivery(1.5) == (False, False)
    for i in range(20):
        made.step(1.5 + i)
    assert any(robot.physics.duties)


def test_a_fifth_of_the_messages_is_lost_but_never_two_in_a_row(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "lost_messages", share=0.2)
    came = [made.delivery(0.0)[0] for _ in range(5000)]
    assert came.count(False) / len(came) == pytest.approx(0.2, abs=0.02)
    assert all(a or b for a, b in itertools.pairwise(came))


def test_stale_boards_repeat_themselves(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    robot.physics.duties[1] = -0.5
    made = effect(robot, "stale_repeats", after=0.5, lasting=0.1)
    values = []
    for i in range(60):
        values.append(shown(robot, made, CYCLE_S * i, "gamma_1"))
        robot.run(0.05)
    begin = math.ceil(0.5 / CYCLE_S)
    assert len(set(values[begin : begin + 6])) == 1
    assert len(set(values[:begin])) > 10


def test_a_firmware_reset_zeroes_duties_and_counters(place: Place) -> None:
    robot = place(straight())
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    robot.run(1.0)
    made = effect(robot, "firmware_reset", after=1.0)
    assert made.step(0.9) is None
    incident = made.step(1.0)
    assert incident is not None
    assert incident.what == "boards_restarted"
    assert not robot.physics.duties.any()
    assert shown(robot, made, 1.1, "theta_1") == pytest.approx(0.0, abs=5.0)
    assert abs(shown(robot, made, 1.1, "gamma_1") or 0.0) > 500
    assert made.step(2.0) is None


def test_a_hanging_controller_neither_says_nor_hears_anything_for_a_while(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "controller_hang", after=1.0, lasting=0.5)
    robot.drive(0.3)
    assert made.step(0.9) is None
    assert made.delivery(0.9) == (True, True)
    incident = made.step(1.0)
    assert incident is not None
    assert (incident.what, incident.until_s) == ("controller_hangs", 1.5)
    assert made.delivery(1.4) == (False, False)
    assert shown(robot, made, 1.4, "gamma_1") is None
    assert made.delivery(1.5) == (True, True)
    assert shown(robot, made, 1.5, "gamma_1") is not None
    assert max(robot.physics.duties) == 0.3


def test_a_controller_that_hangs_without_an_end_hangs_for_good(place: Place) -> None:
    made = effect(place(straight()), "controller_hang", after=1.0)
    made.step(1.0)
    assert made.delivery(1e6) == (False, False)


def test_a_restarting_controller_leaves_the_motors_as_they_were(place: Place) -> None:
    robot = place(straight())
    robot.drive(0.3)
    made = effect(robot, "controller_reset", after=1.0, lasting=2.0)
    incident = made.step(1.0)
    assert incident is not None
    assert (incident.what, incident.until_s) == ("controller_restarted", 3.0)
    assert max(robot.physics.duties) == 0.3


def test_sudden_defects_come_again_at_random(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    made = effect(robot, "stray_motion", every=2.0)
    struck = 0
    for i in range(10_000):
        robot.physics.duties[:] = 0.0
        came = made.step(0.01 * i) is not None
        assert any(robot.physics.duties) is came
        struck += came
    assert struck == pytest.approx(50, abs=20)


def test_every_defect_of_the_profile_can_be_switched_on(profile: Profile, place: Place) -> None:
    defects = profile.simulation.defects
    robot = place(straight())
    made = put_to_work(named(list(defects), profile, seed=1), robot.electronics)
    assert len(made) == len(defects)


def test_an_unknown_defect_is_refused_with_a_suggestion(profile: Profile) -> None:
    name = next(iter(profile.simulation.defects))
    with pytest.raises(UsageError, match=f"did you mean '{name}'"):
        named([name + "x"], profile, seed=1)


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("gamma_4_stiff:friction=0.5Nm,after=2s", {"friction": 0.5, "after": 2.0}),
        ("gamma_2_drops: every = 20 s , lasting = 300 ms", {"every": 20.0, "lasting": 0.3}),
        ("gamma_1_zero_jumps:by=-13deg", {"raw": {"gamma_1": -148.0}}),
        ("gamma_2_sticks:shows=45deg", {"raw": {"gamma_2": 512.0}}),
        ("gamma_3_spikes:shows=90deg", {"raw": {"gamma_3": 1024.0, "bend_torque_3": 400.0}}),
        ("imu_spikes:shows=0m/s^2", {"raw": {"acc_x": 0.0, "acc_z": 0.0}}),
        ("messages_lost:share=25%", {"share": 0.25}),
        ("wheel_1_dead:", {}),
    ],
)
def test_belief_is_tried_with_defects_whose_numbers_and_times_are_given(
    profile: Profile, text: str, numbers: dict[str, Any]
) -> None:
    plain = profile.simulation.defects[text.partition(":")[0]]
    ((defect, _),) = named([text], profile, seed=1)
    assert defect == plain.model_copy(update=numbers)


def test_a_range_is_drawn_from_the_seed(profile: Profile) -> None:
    text = "gamma_4_stiff:friction=0.2Nm..0.9Nm,after=0s..20s"
    pairs = [named([text, text], profile, seed=seed) for seed in range(40)]
    for numbers, least, most in (
        ([one.friction for pair in pairs for one, _ in pair], 0.2, 0.9),
        ([one.after for pair in pairs for one, _ in pair], 0.0, 20.0),
    ):
        assert least <= min(numbers) < 0.8 * least + 0.2 * most
        assert 0.2 * least + 0.8 * most < max(numbers) <= most
        assert len(set(numbers)) == 80
    assert named([text], profile, seed=7)[0][0] == pairs[7][0][0]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("gamma_4_stiff:friction=200mNm..900mNm,after=2s", r"friction=\d{3}\.\d\dmNm,after=2s"),
        ("messages_lost:share=10%..40%", r"share=\d\d\.\d{3}%"),
        ("gamma_1_zero_jumps:by=-20deg..-10deg", r"by=-1\d\.\d{3}deg"),
        ("gamma_4_stiff:after=2s", "after=2s"),
    ],
)
def test_the_drawn_number_is_shown_and_makes_the_same_defect(
    profile: Profile, text: str, shown: str
) -> None:
    texts = ["wheel_1_dead", text]
    known = drawn(texts, profile, seed=3)
    assert known[0] == "wheel_1_dead"
    assert re.fullmatch(f"{text.partition(':')[0]}:{shown}", known[1])
    assert drawn(known, profile, seed=3) == known
    for (as_range, its), (as_number, others) in zip(
        named(texts, profile, seed=3), named(known, profile, seed=3), strict=True
    ):
        assert as_range == as_number
        assert its.random() == others.random()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gamma_4_stiff:fricton=2Nm", "takes no number 'fricton': did you mean 'friction'?"),
        ("wheel_1_dead:lasting=2s", "'lasting': expected one of friction, after"),
        ("gamma_4_stiff:friction=2mm", "friction: expected a torque such as '0.8 Nm', got '2mm'"),
        ("gamma_4_stiff:after=2", "after: expected a duration such as '2 s', got '2' without a"),
        ("gamma_4_stiff:after", "after: expected KEY=VALUE, got 'after'"),
        ("gamma_4_stiff:after=1s,after=2s", "after: given twice"),
        ("gamma_4_stiff:friction=-1Nm", "friction: expected at least 0, got '-1Nm'"),
        ("messages_lost:share=80%", "share: expected at least 0 and at most 0.5, got '80%'"),
        ("gamma_1_zero_jumps:by=3s", "by: expected an angle such as '28 deg', got '3s'"),
        ("wheel_1_dead:after=5s..2s", "expected a range from the smaller to the larger value"),
        ("wheel_1_dead:after=5s..", "after: expected a duration such as '2 s', got ''"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(profile: Profile, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=re.escape(message)):
        named([text], profile, seed=1)


def test_all_defects_whose_numbers_do_not_fit_are_named(profile: Profile) -> None:
    with pytest.raises(UsageError, match=r"(?s)gamma_4_stiff: friction.*wheel_1_dead: after"):
        named(["gamma_4_stiff:friction=1", "wheel_1_dead:after=1"], profile, seed=1)


def test_a_wheel_dies_in_the_middle_of_a_run_and_its_angle_stands_still(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "dead_wheel", wheels=("wheel_3",), after=2.0)
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    robot.run(2.0)
    made.step(1.9)
    before = shown(robot, made, 1.9, "theta_3")
    made.step(2.0)
    robot.run(1.0)
    assert before != 0.0
    assert shown(robot, made, 3.0, "theta_3") == before
    assert shown(robot, made, 3.0, "wheel_current_3") == 0.0
    assert robot.physics.body[2, columns.WHEEL_RATE] == 0.0


def test_a_joint_becomes_stiff_in_the_middle_of_a_run(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    made = effect(robot, "stiff_joint", joint="gamma_2", friction=0.9, after=1.0)
    made.step(0.9)
    assert robot.physics.body[2, columns.JOINT_FRICTION] < 0.1
    assert (made.due_s, made.glides_until_s(0.9)) == (1.0, 1.0)
    made.step(1.0)
    assert robot.physics.body[2, columns.JOINT_FRICTION] == 0.9
    assert made.glides_until_s(1.0) == math.inf


def test_a_silent_board_reports_nothing_for_a_while_and_the_others_report(place: Place) -> None:
    robot = place(straight())
    made = effect(robot, "silent_boards", boards=(26,), after=1.0, lasting=0.5)
    silent = [shown(robot, made, t, "gamma_3") is None for t in (0.9, 1.0, 1.4, 1.6)]
    assert silent == [False, True, True, False]
    assert shown(robot, made, 1.2, "gamma_4") is not None
    assert made.delivery(1.2) == (True, True)


def test_messages_are_lost_from_a_certain_time_on(place: Place) -> None:
    made = effect(place(straight()), "lost_messages", share=0.5, after=1.0)
    assert all(made.delivery(0.5) == (True, True) for _ in range(50))
    assert not all(made.delivery(1.5) == (True, True) for _ in range(50))
