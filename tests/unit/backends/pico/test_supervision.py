"""What sensors say is held against what can be, without hiding what is."""

from __future__ import annotations

from math import isnan, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.backends.pico.plan import Plan
from pirate_sm.backends.pico.supervision import Supervision, Watched
from pirate_sm.model.events import SensorFrame

BOARD = 7
EVERY_S = 0.1
ANGLE = Watched(
    0, "elbow", low=-1000, high=1000, rate=300, slack=20, slot=0, joint=True, moved=200,
    least_duty=0.2, load=1, full_load=300,
)  # fmt: skip
WHEEL = Watched(2, "wheel", rate=2000, slack=100, slot=1, wheel=True, moved=100)


class Bench:
    def __init__(self) -> None:
        self.supervision = Supervision({BOARD: [ANGLE, WHEEL]}, wheels=[1])
        self.now_s = 0.0
        self.codes: list[str] = []

    def say(self, angle: float, load: float = 250, wheel: float = 0) -> float:
        """The angle as it is passed on."""
        self.now_s += EVERY_S
        frame, faults = self.supervision.look(SensorFrame(BOARD, (angle, load, wheel)), self.now_s)
        self.codes += [fault.code for fault in faults]
        return frame.values[0]


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.say(0)
    return bench


@pytest.mark.parametrize("length", [1, 2])
def test_a_spike_is_not_passed_on(bench: Bench, length: int) -> None:
    shown = [bench.say(value) for value in [1, *[-900] * length, 2, 3]]

    assert shown == [1, *[1] * length, 2, 3]
    assert bench.supervision.hidden == 1
    assert bench.codes == []


def test_a_sensor_that_spikes_all_the_time_is_a_fault_once(bench: Bench) -> None:
    for _ in range(8):
        bench.say(-900)
        bench.say(0)

    assert bench.codes == ["sensor.spiking"]


def test_a_value_that_jumps_and_stays_is_what_it_is(bench: Bench) -> None:
    assert [bench.say(value) for value in [500, 500, 500, 501]] == [0, 0, 500, 501]


def test_what_goes_on_the_same_way_is_a_trend_and_passes_at_once(bench: Bench) -> None:
    assert [bench.say(value) for value in [200, 400, 600, 900]] == [0, 400, 600, 900]


@given(st.lists(st.floats(-49, 49), min_size=1, max_size=60))
def test_a_motion_that_is_possible_is_passed_on_as_it_is(steps: list[float]) -> None:
    bench, angle = Bench(), 0.0
    for step in steps:
        angle = min(1000.0, max(-1000.0, angle + step))
        assert bench.say(angle) == angle
    assert bench.codes == []


@given(st.lists(st.floats(-1000, 1000), max_size=60), st.floats(-1000, 1000))
def test_no_value_is_held_back_for_more_than_two_readings(before: list[float], last: float) -> None:
    bench = Bench()
    for value in before:
        bench.say(value)

    assert last in [bench.say(last) for _ in range(3)]


def test_a_value_that_cannot_be_is_unknown_and_a_fault_until_it_can_be_again(
    bench: Bench,
) -> None:
    shown = [bench.say(5000) for _ in range(5)]

    assert shown[:2] == [0, 0]
    assert all(map(isnan, shown[2:]))
    assert bench.codes == ["sensor.range"]
    assert bench.say(3) == 3


def test_the_torque_of_a_good_bend_is_within_its_range(plan: Plan) -> None:
    torques = [w for board in plan.watched.values() for w in board if "torque" in w.name]

    assert len(torques) == 4
    for each in torques:  # −584 counts were measured in a bend that succeeded
        assert each.low < -2 * 584
        assert each.high > 2 * 584


def test_silence_of_a_channel_stays_silence(bench: Bench) -> None:
    assert isnan(bench.say(nan))


def test_a_driven_motor_without_load_whose_sensor_shows_nothing(bench: Bench) -> None:
    bench.supervision.actuated((0.5, 0.0), bench.now_s)
    for _ in range(30):
        bench.say(0, load=10)

    assert bench.codes == ["sensor.stuck"]


@pytest.mark.parametrize(
    ("duty", "load", "step"),
    [(0.5, 140, 0), (0.1, 0, 0), (0.5, 10, 1)],
    ids=["stalled at the wall", "below what moves it", "it moves"],
)
def test_standing_still_for_a_reason_is_no_fault(
    bench: Bench, duty: float, load: float, step: float
) -> None:
    bench.supervision.actuated((duty, 0.0), bench.now_s)
    for turn in range(30):
        bench.say(turn * step, load=load)

    assert bench.codes == []


def test_a_joint_that_moves_without_being_asked(bench: Bench) -> None:
    bench.supervision.actuated((0.0, 0.0), bench.now_s)
    for turn in range(40):
        bench.say(turn * 20)

    assert bench.codes == ["motion.unasked"]


@pytest.mark.parametrize("damaged", [16, 17, 18, 19, 25])  # at rest after 1.5 s
def test_one_reading_that_the_line_has_damaged_is_no_motion(bench: Bench, damaged: int) -> None:
    bench.supervision.actuated((0.0, 0.0), bench.now_s)
    for turn in range(30):
        bench.say(0, wheel=250 if turn == damaged else 0)

    assert bench.codes == []


def test_a_wheel_that_slides_all_the_time_moves_without_being_asked(bench: Bench) -> None:
    bench.supervision.actuated((0.0, 0.0), bench.now_s)
    for turn in range(30):
        bench.say(0, wheel=turn * 150)

    assert bench.codes == ["motion.unasked"]


def test_nothing_is_unasked_while_a_wheel_is_driven(bench: Bench) -> None:
    bench.supervision.actuated((0.0, 1.0), bench.now_s)
    for turn in range(40):
        bench.say(turn * 20, wheel=turn * 150)

    assert bench.codes == []


def test_after_a_restart_counters_may_begin_anew(bench: Bench) -> None:
    bench.say(0, wheel=5000)
    bench.supervision.forget()

    assert bench.say(900) == 900


def test_frames_that_have_waited_and_come_at_once_are_no_spikes() -> None:
    """A program that stood still for a second reads what came meanwhile in one moment."""
    current = Watched(1, "current", low=-500, high=500, slot=0)
    supervision = Supervision({BOARD: [ANGLE, current]}, wheels=[1], frame_s=EVERY_S)
    codes = []
    for number in range(30):
        angle, load = 25.0 * number, 250.0 * (number % 2)
        frame, faults = supervision.look(SensorFrame(BOARD, (angle, load, 0)), 5.0)
        codes += [fault.code for fault in faults]
        assert frame.values[:2] == (angle, load)

    assert codes == []
