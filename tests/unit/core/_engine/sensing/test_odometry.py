"""How far a robot may be from its odometry, by what its wheels and joints show."""

from __future__ import annotations

from functools import cache
from math import asin, inf, isnan, nan, pi, sin, sqrt

import pytest
from driving import PIRATE

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.known_signals import (
    DistanceMemory,
    MotorRequest,
    Sensing,
    nothing_known,
)
from pirate_sm.core._engine.sensing.odometry import BASE_M, counting, judge, unheard
from pirate_sm.core._loading.robot.loader import load_robot

ROUND_S, SPEED = 0.1, 0.8
BEYOND = 1.05 + 1e-9
"""Just more than a motor may turn faster than its profile says; at 1.05 itself rounding decides."""
LEVEL, UP = 0.0, pi / 2
EDGE = 1 - sqrt(1 - (6 / 24) ** 2)
"""What a wheel of 24 mm lacks on the edge of a tyre of 12 mm."""


@cache
def robot() -> RobotSpec:
    return load_robot(PIRATE).normal


def top_m_s() -> float:
    return robot().wheels[0].top_m_s


def setpoints(duty: float = 1.0) -> tuple[float, ...]:
    values = [0.0] * len(robot().slots)
    for wheel in robot().wheels:
        values[wheel.slot] = duty if wheel.metres_per_rad > 0 else -duty
    return tuple(values)


class World:
    """A robot that drives along a pipe, round by round.

    Attributes:
        speeds: Speed of each wheel, as shares of that at full duty without load.
        force: Force of all wheels along their rims, as a share of the weight.
        forces: Share of each wheel in that.
        joints_rad: Angle of each joint.
        torques_nm: What each joint bears.
        spans_m: Inner diameter that each part shows.
        bores_m: Those of the pipe.
    """

    def __init__(self, pitch_rad: float = LEVEL) -> None:
        self.pitch_rad = pitch_rad
        self.speeds = [SPEED] * 6
        self.force, self.forces = 0.0, [1 / 6] * 6
        self.joints_rad, self.torques_nm = [0.0] * 4, [0.0] * 4
        self.spans_m, self.held, self.bores_m = [0.12, 0.12], (0, 1), (0.11, 0.12)
        self.now_s, self.duty = 10.0, 1.0
        self.silent: set[int] = set()
        fresh = nothing_known(robot())
        numbers = [0.0 if at != robot().bound else nan for at in range(len(fresh.numbers))]
        sensing = fresh._replace(
            numbers=tuple(numbers),
            heard_s=(self.now_s,) * len(fresh.heard_s),
            angles=(0.0,) * 6,
            shares=(1 / 6,) * 6,
            asked=MotorRequest(setpoints(), 0.0, True),
        )
        self.sensing: Sensing = counting(robot(), sensing, DistanceMemory(), read=True)
        self.judge()

    def judge(self) -> None:
        self.sensing = judge(
            robot(),
            self.sensing,
            setpoints(self.duty),
            self.pitch_rad,
            self.now_s,
            self.held,
            self.bores_m,
        )

    def drive(self, rounds: int = 1) -> float:
        """Drive on; return by how much the bound has grown, m."""
        before_m = self.width_m
        for _ in range(rounds):
            self.now_s += ROUND_S
            numbers, angles = list(self.sensing.numbers), list(self.sensing.angles)
            heard_s = list(self.sensing.heard_s)
            for wheel, board in zip(robot().wheels, robot().wheel_boards, strict=True):
                if wheel.place in self.silent:
                    continue
                way_m = self.speeds[wheel.place] * wheel.top_m_s * ROUND_S
                angles[wheel.place] += way_m / wheel.metres_per_rad
                numbers[wheel.speed] = way_m / ROUND_S / wheel.metres_per_rad
                newtons = self.force * robot().body.weight_n * self.forces[wheel.place]
                numbers[wheel.load] = newtons / wheel.n_per_a
                heard_s[board] = self.now_s
            joints = [at for at in robot().body.joints if at >= 0]
            for at, angle in zip(joints, self.joints_rad, strict=True):
                numbers[at] = angle
            assert robot().traction is not None
            torques = [at for at in robot().traction.joint_torques if at >= 0]
            for at, torque_nm in zip(torques, self.torques_nm, strict=True):
                numbers[at] = torque_nm
            for part, span_m in zip(robot().body.parts, self.spans_m, strict=True):
                numbers[part.diameter] = span_m
            self.sensing = self.sensing._replace(
                numbers=tuple(numbers), angles=tuple(angles), heard_s=tuple(heard_s)
            )
            self.judge()
        return self.width_m - before_m

    @property
    def width_m(self) -> float:
        return self.sensing.distance.width_m

    @property
    def bound_m(self) -> float:
        return self.sensing.numbers[robot().bound]


def way_m(rounds: int, speed: float = SPEED) -> float:
    return rounds * speed * top_m_s() * ROUND_S


def test_the_bound_begins_with_what_is_always_possible() -> None:
    assert World().bound_m == BASE_M


@pytest.mark.parametrize("force", [-0.2, 0.0, 0.2])
def test_wheels_that_roll_are_wrong_by_a_small_share_of_the_way(force: float) -> None:
    world = World()
    world.force = abs(force)

    assert world.drive(10) == pytest.approx(0.006 * way_m(10))
    assert world.sensing.distance.rolled_m == pytest.approx(way_m(10))
    assert world.bound_m == pytest.approx(BASE_M + 0.006 * way_m(10))


def test_belief_in_a_bound_ends_with_the_reports_that_are_lost() -> None:
    """What wheels have rolled since they were heard is not in the odometry yet."""
    world = World()
    world.drive(5)
    world.silent = {0, 2, 4}

    world.drive(3)

    assert world.bound_m == pytest.approx(world.width_m + BASE_M + way_m(3) / 2)
    world.sensing = world.sensing._replace(loss=0.4)
    lost_m = 0.4 * robot().link.period_s * SPEED * top_m_s()  # until the next reports
    world.drive(1)
    assert world.bound_m == pytest.approx(world.width_m + BASE_M + way_m(4) / 2 + lost_m)
    world.silent = set()
    world.drive(1)
    assert world.bound_m == pytest.approx(world.width_m + BASE_M + lost_m)


def test_belief_in_a_bound_does_not_come_back_by_a_wheel_that_is_seen_to_brake() -> None:
    """Wheels that do not report may have stopped, too."""
    world = World()
    world.drive(5)
    world.silent = {0, 1, 2, 3, 4}
    world.drive(2)
    world.speeds = [0.0] * 6
    world.drive(2)

    assert world.bound_m > world.width_m + BASE_M + 0.9 * way_m(4) * 5 / 6


def test_belief_in_a_bound_does_not_come_back_once_silent_wheels_count_no_more() -> None:
    world = World()
    world.drive(5)
    world.silent = {0, 2, 4}
    rounds = int(robot().link.silent_after_s / ROUND_S)
    world.drive(rounds - 1)
    before_m = world.bound_m

    world.drive(3)  # they are silent for too long, and count no more

    assert world.bound_m > before_m


def test_backward_it_is_the_same() -> None:
    world = World()
    world.speeds = [-SPEED] * 6

    assert world.drive(10) == pytest.approx(0.006 * way_m(10))
    assert world.sensing.distance.rolled_m == pytest.approx(way_m(10))


def test_up_a_pipe_wheels_that_bear_the_weight_roll() -> None:
    world = World(UP)
    world.force = 1.0
    world.drive(5)

    assert world.drive(10) == pytest.approx(0.006 * way_m(10))


def clamped(world: World) -> World:
    """Both Vs press with 104 N in all, of which 3 % are 0.4 times the weight."""
    lean, oblique = asin((0.120 - 0.048) / 0.090), asin((0.120 - 0.048) / 0.098)
    world.joints_rad = [-2 * lean, lean + oblique, -(lean + oblique), 2 * lean]
    world.torques_nm = [-0.7, 0.0, 0.0, 0.7]
    return world


@pytest.mark.parametrize("pitch_rad", [LEVEL, 0.1, UP])
@pytest.mark.parametrize("dead", [(), (2, 3), (0, 1, 2)])
def test_motors_that_overcome_what_resists_rolling_push_against_nothing(
    pitch_rad: float, dead: tuple[int, ...]
) -> None:
    world = clamped(World(pitch_rad))
    world.force = sin(pitch_rad) + 0.6
    for at in dead:
        world.speeds[at] = 0.0
    world.forces = [0.0 if at in dead else 1 / (6 - len(dead)) for at in range(6)]
    world.force += sum(robot().wheels[at].drag_n for at in dead) / robot().body.weight_n
    world.drive(15)

    assert world.sensing.distance.out == set(dead)
    assert world.drive(10) == pytest.approx(0.006 * way_m(10))


def test_what_resists_rolling_bears_weight_of_a_robot_that_drives_down() -> None:
    world = clamped(World(-UP))
    world.speeds[2] = world.speeds[3] = 0.0
    dragged = 2 * robot().wheels[2].drag_n / robot().body.weight_n
    world.force, world.forces = 1.0 - dragged - 0.35, [0.25, 0.25, 0.0, 0.0, 0.25, 0.25]
    world.drive(15)

    assert world.drive(10) == pytest.approx(0.006 * way_m(10))
    assert world.sensing.distance.sliding_m_s == 0.0


@pytest.mark.parametrize(("pitch_rad", "force"), [(LEVEL, 0.9), (UP, 1.6)])
def test_belief_ends_where_motors_overcome_more_or_wheels_turn_unalike_on_a_slope(
    pitch_rad: float, force: float
) -> None:
    world = slipping(clamped(World(pitch_rad)))
    world.force = force
    world.drive(5)

    assert world.drive(5) > 0.8 * way_m(5, 0.7)


def slipping(world: World) -> World:
    """Wheels give more than gravity asks for, and those in the middle turn slower."""
    world.speeds = [SPEED, 0.6, SPEED, SPEED, 0.6, SPEED]
    world.forces = [0.05, 0.4, 0.05, 0.05, 0.4, 0.05]
    return world


@pytest.mark.parametrize(("pitch_rad", "force"), [(LEVEL, 0.6), (UP, 1.6), (UP, 0.5)])
def test_belief_in_a_way_ends_where_all_wheels_may_slip(pitch_rad: float, force: float) -> None:
    world = slipping(World(pitch_rad))
    world.force = force
    world.drive(5)

    grown_m = world.drive(5)

    assert grown_m >= way_m(5, 0.7)
    assert world.bound_m == pytest.approx(BASE_M + world.width_m)


def test_while_a_robot_starts_what_follows_decides_whether_it_slips() -> None:
    world = World()
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(), world.now_s, True))
    slipping(world).force = 0.6
    assert world.drive(3) < 0.01 * way_m(3), "not yet"
    world.speeds, world.forces, world.force = [SPEED] * 6, [1 / 6] * 6, 0.0
    assert world.drive(3) == pytest.approx(0.006 * way_m(3)), "it did not slip"

    world = World()
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(), world.now_s, True))
    slipping(world).force = 0.6
    world.drive(3)
    assert world.drive(2) > 0.9 * way_m(5, 0.7), "it did, since it began"


def test_belief_is_not_kept_by_arrays_that_only_steer_joints_or_trim_duties() -> None:
    world = slipping(World())
    world.force, grown_m = 0.6, 0.0
    for part in range(10):
        duties = setpoints(1.0 - 0.01 * part)
        world.sensing = world.sensing._replace(asked=MotorRequest(duties, world.now_s, True))
        grown_m += world.drive(1)
    assert grown_m >= way_m(5, 0.7), "it has not begun to drive with each of them"


def test_a_robot_that_lacks_force_on_a_slope_slides_faster_and_faster() -> None:
    world = slipping(World(UP))
    world.force = 0.2
    world.drive(5)

    first_m, second_m, third_m = world.drive(5), world.drive(5), world.drive(5)

    assert world.sensing.distance.sliding_m_s > 1.0
    assert third_m - second_m == pytest.approx(second_m - first_m, rel=0.1)
    assert second_m > first_m + 0.5
    world.speeds, world.forces, world.force = [SPEED] * 6, [1 / 6] * 6, 1.0
    world.drive(1)
    assert world.sensing.distance.sliding_m_s == 0.0


def test_level_nothing_slides() -> None:
    world = slipping(World())
    world.force = 0.6
    world.drive(10)

    assert world.sensing.distance.sliding_m_s == 0.0


def test_joints_that_turn_while_wheels_slip_are_a_way_too() -> None:
    still, bent = slipping(World()), slipping(World())
    for world in (still, bent):
        world.force = 0.6
        world.drive(5)
    bent.joints_rad = [0.1, 0.0, 0.0, 0.0]
    length_m = max(robot().body.lengths_m)

    assert bent.drive() - still.drive() == pytest.approx((0.1 - 0.006) * length_m, abs=1e-6)
    assert bent.drive() == pytest.approx(still.drive()), "it has turned once"


def test_joints_that_turn_while_wheels_roll_are_none() -> None:
    world = World()
    world.drive(5)
    world.joints_rad = [0.1] * 4

    assert world.drive() == pytest.approx(0.006 * way_m(1))


def test_belief_ends_only_in_part_where_one_part_rolls_and_the_other_slips() -> None:
    world = World()
    world.speeds = [SPEED] * 3 + [SPEED, 0.6, SPEED]
    world.forces = [0.0] * 3 + [0.15, 0.7, 0.15]
    world.force = 0.6
    world.drive(5)

    grown_m = world.drive(5)

    mean_m = way_m(5, (5 * SPEED + 0.6) / 6)
    assert grown_m == pytest.approx(0.35 * (way_m(5) - mean_m) + 0.006 * mean_m, rel=0.02)


@pytest.mark.parametrize(
    ("spans_m", "held", "bores_m", "share"),
    [
        ([0.100, 0.100], (0, 1), (0.12,), 20 / 72),
        ([0.100, 0.108], (0, 1), (0.12,), 16 / 72),
        ([0.100, 0.100], (0, 1), (0.11, 0.12), 10 / 62),
        ([0.110, 0.110], (0, 1), (0.12, 0.11), 10 / 72),  # it began in 120 mm, and never spanned it
        ([0.100, 0.117], (0, 1), (0.12,), 3 / 72),  # one nearly lies along the axis
        ([0.100, 0.120], (0, 1), (0.12,), 0),  # one does
        ([0.100, 0.120], (0,), (0.12,), 20 / 72),
        ([0.110, 0.110], (0, 1), (0.11, 0.12), 0),
        ([0.113, 0.113], (0, 1), (0.11, 0.12), 0),
        ([0.125, 0.125], (0, 1), (0.12,), 0),
        ([0.100, nan], (0, 1), (0.12,), 0),
        ([0.100, 0.100], (0, 1), (), 0),
        ([0.100, 0.100], (), (0.12,), 0),
    ],
)
def test_belief_in_a_way_ends_where_parts_lie_beside_the_axis_of_the_pipe(
    spans_m: list[float], held: tuple[int, ...], bores_m: tuple[float, ...], share: float
) -> None:
    world = World()
    world.spans_m, world.held, world.bores_m = spans_m, held, bores_m

    share = min(share, EDGE)
    assert world.drive(10) == pytest.approx((0.006 + min(0.25 * share, 0.02)) * way_m(10))
    # The odometry has what they lack taken off; what the wheels show is added elsewhere.
    assert world.sensing.numbers[robot().odometry] == pytest.approx(-share * way_m(10))


@pytest.mark.parametrize(("span_m", "lack"), [(0.110, 10 / 72), (0.102, 18 / 72)])
def test_wheels_that_differ_no_more_than_parts_lack_beside_the_axis_do_not_slip_for_that(
    span_m: float, lack: float
) -> None:
    world = World()
    world.spans_m, world.bores_m = [span_m] * 2, (0.12,)
    world.speeds = [0.64, 0.8, 0.96] * 2
    world.drive(5)

    lack = min(lack, EDGE)
    lean_m = (0.006 + min(0.25 * lack, 0.02)) * way_m(5)
    excess_m = max(0.0, way_m(5, 0.16) - lack * way_m(5))
    assert world.drive(5) == pytest.approx(lean_m + 0.35 * excess_m)


@pytest.mark.parametrize("slipped", [False, True])
def test_a_stop_that_boards_report_one_after_the_other_is_no_slip(slipped: bool) -> None:
    """Its wheels have been stopped, and only some boards show it yet; before that they rolled."""
    world = World()
    if slipped:
        world.force, world.speeds = 0.6, [SPEED, 0.6] * 3
    world.drive(6)
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(0.0), world.now_s, False))
    world.force, world.speeds = 0.6, [SPEED, 0.6] * 3

    grown_m = world.drive()
    world.duty, world.speeds = 0.0, [0.0] * 6
    grown_m += world.drive()

    rolled_m = way_m(1, (SPEED + 0.6) / 2)
    assert grown_m == pytest.approx((1.006 if slipped else 0.006) * rolled_m)


def test_belief_in_a_stop_ends_where_wheels_are_driven_and_slip_long_after_it_was_asked_for() -> (
    None
):
    """The array that stops them was lost, or comes late."""
    world = World()
    world.drive(6)
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(0.0), world.now_s, False))
    world.force, world.speeds = 0.6, [SPEED, 0.6] * 3

    assert world.drive(20) > 0.5 * way_m(10, (SPEED + 0.6) / 2)


def test_a_part_that_spanned_the_wide_pipe_is_in_the_narrow_one_when_it_spans_less() -> None:
    world = World()
    world.bores_m = (0.12, 0.11)
    world.drive(3)
    world.spans_m = [0.11, 0.11]

    assert world.drive(10) == pytest.approx(0.006 * way_m(10))


def test_a_wheel_that_is_dead_is_taken_out_with_the_way_that_it_lacks() -> None:
    world = World()
    world.speeds = [0.0] + [SPEED] * 5
    world.force = 0.0
    world.drive(10)

    odometry_m = world.sensing.numbers[robot().odometry]
    assert world.sensing.distance.out == {0}
    assert odometry_m > 0.0, "what it lacked has been added"


@pytest.mark.parametrize(("span_m", "share"), [(0.118, 0.08), (0.1199, 4 * 0.1 / 72), (0.121, 0)])
def test_belief_in_the_way_of_wheels_that_lean_ends_sooner_while_they_drag_dead_ones(
    span_m: float, share: float
) -> None:
    world = World()
    world.spans_m, world.bores_m = [span_m] * 2, (0.12,)
    world.speeds, world.force = [SPEED] * 3 + [0.0] * 3, 0.0
    world.drive(10)

    assert world.sensing.distance.out == {3, 4, 5}
    assert world.drive(5) == pytest.approx((0.006 + share) * way_m(5))


@pytest.mark.parametrize(
    ("driving", "away_s", "gap_s"),
    [(True, nan, inf), (True, 1.0, 2.0), (True, 5.0, 5.0), (False, 5.0, None)],
)
def test_belief_in_a_distance_has_a_gap_while_nobody_heard_the_robot(
    driving: bool, away_s: float, gap_s: float | None
) -> None:
    world = World()
    world.drive(3)
    asked = MotorRequest(setpoints(), 0.0, driving)
    distance = world.sensing.distance._replace(running=driving, out=frozenset({2}))
    sensing = world.sensing._replace(asked=asked, distance=distance)

    after = unheard(robot(), sensing, world.now_s + 2.0, away_s)

    lost_m = 0.0 if gap_s is None else top_m_s() * (gap_s + robot().link.period_s)
    assert after.width_m == pytest.approx(world.width_m + lost_m)
    assert not after.running
    assert after.out == frozenset()


def test_a_run_that_goes_on_counts_on_and_one_that_reads_no_distance_has_no_bound() -> None:
    before = DistanceMemory(width_m=0.03, rolled_m=1.5, running=True, out=frozenset({1}))
    read = counting(robot(), nothing_known(robot()), before, read=True)
    unread = counting(robot(), nothing_known(robot()), before, read=False)

    assert (read.distance.width_m, read.distance.rolled_m) == (0.03, 1.5)
    assert (read.distance.running, read.distance.out) == (False, frozenset())
    assert read.numbers[robot().bound] == pytest.approx(BASE_M + 0.03)
    assert isnan(unread.numbers[robot().bound])
    assert 0.0 < read.distance.every_s < robot().link.period_s < unread.distance.every_s


def test_it_is_judged_once_a_round_and_from_the_start_on() -> None:
    world = World()
    memory = world.sensing.distance
    assert (memory.running, memory.begun_s, memory.at_s) == (True, 10.0, 10.0)
    assert memory.due_s == pytest.approx(10.0 + memory.every_s)
    assert memory.strayed_m == (0.0,) * 6
    assert memory.odd_s == (inf,) * 6

    world.now_s += memory.every_s / 2
    world.judge()
    assert world.sensing.distance is memory

    world.drive()
    assert world.sensing.distance.at_s == world.now_s


def test_a_robot_that_stands_is_not_judged() -> None:
    world = World()
    world.drive(3)
    world.sensing = world.sensing._replace(
        asked=MotorRequest(setpoints(0.0), 0.0, False), shares=(0.0,) * 6
    )
    world.speeds = [0.0] * 6
    world.drive()
    assert not world.sensing.distance.running

    before = world.sensing
    world.now_s += 1.0
    world.judge()
    assert world.sensing is before


def test_a_slope_that_is_not_known_is_the_one_that_was_known_last() -> None:
    world = World(UP)
    world.force = 1.0
    world.drive(5)
    world.pitch_rad = nan

    assert world.drive(5) == pytest.approx(0.006 * way_m(5))
    assert world.sensing.distance.pitch_rad == UP


def test_a_part_that_turns_alike_and_bears_unevenly_slips_too() -> None:
    world = World()
    world.speeds = [SPEED] * 3 + [SPEED, 0.6, SPEED]
    world.forces = [0.02, 0.46, 0.02, 0.05, 0.4, 0.05]
    world.force = 0.6
    world.drive(5)

    assert world.drive(5) > 0.9 * way_m(5, 0.6)


@pytest.mark.parametrize(
    ("speeds", "off"),
    [
        ([SPEED] * 3 + [SPEED, 0.7, SPEED], 0.1 / 6),
        ([SPEED, 0.7, SPEED] * 2, 0.0),
        ([SPEED, 0.6, SPEED] * 2, 0.4 / 3),
        ([SPEED] * 3 + [0.77, 0.77, 0.77], 0.0),
    ],
)
def test_wheels_that_differ_without_force_may_slip_in_part(speeds: list[float], off: float) -> None:
    world = World()
    world.speeds = speeds
    world.drive(5)

    mean_m = way_m(5, sum(speeds) / 6)
    assert world.drive(5) == pytest.approx(0.006 * mean_m + 0.35 * way_m(5, off), rel=0.02)


def test_wheels_that_differ_while_a_robot_starts_do_not_count() -> None:
    world = World()
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(), world.now_s, True))
    world.speeds = [SPEED, 0.6, SPEED] * 2

    assert world.drive(3) == pytest.approx(0.006 * way_m(3, 2.2 / 3))


@pytest.mark.parametrize(("speed", "lasts"), [(0.72, True), (0.3, False)])
def test_belief_in_a_way_lasts_once_a_wheel_that_has_spun_turns_with_the_others_again(
    speed: float, lasts: bool
) -> None:
    world = World(0.07)
    world.force = 0.07
    world.speeds[0] = 1.0
    while not world.sensing.distance.out:
        world.drive()
    world.speeds = [speed, SPEED, 0.6, SPEED, 0.6, SPEED]

    grown_m = world.drive(6)

    assert world.sensing.distance.out == {0}
    assert (grown_m < 0.1 * way_m(6)) == lasts


@pytest.mark.parametrize(("pitch_rad", "slips"), [(UP, True), (0.1, False)])
def test_on_a_slope_wheels_that_differ_slip_although_they_bear_the_weight(
    pitch_rad: float, slips: bool
) -> None:
    world = slipping(World(pitch_rad))
    world.force = 1.0 if slips else 0.1
    world.drive(5)

    assert (world.drive(5) > 0.9 * way_m(5, 0.7)) == slips


def test_where_few_boards_report_what_follows_decides_whether_wheels_slip() -> None:
    world = World(UP)
    world.force = 1.0
    world.drive(5)
    before_m = world.width_m
    world.silent = {0, 1, 3, 4}
    world.drive(2)
    assert world.width_m - before_m < 0.02 * way_m(2), "not yet"
    assert world.sensing.distance.pending_m > 0.0

    world.silent = set()
    world.drive(3)

    assert world.width_m - before_m < 0.02 * way_m(5)
    assert world.sensing.distance.pending_m == 0.0


def test_wheels_that_are_pushed_hold_against_those_that_push() -> None:
    world = World()
    world.speeds = [1.01, 0.99] * 3
    world.force = 0.6
    world.drive(5)

    assert world.drive(5) == pytest.approx(0.006 * way_m(5, 1.0))


@pytest.mark.parametrize(
    ("fastest", "forces", "pitch_rad", "rolls"),
    [
        (BEYOND, [0.1, 0.02], LEVEL, True),
        (-BEYOND, [0.1, 0.02], LEVEL, True),
        # The faster it turns, the less force: wheels that slip.
        (BEYOND, [0.02, 0.1], LEVEL, False),
        (1.0, [0.1, 0.02], LEVEL, False),  # its motor may turn so fast
        (BEYOND, [0.1, 0.02], 0.6, False),  # up a slope it may slide back
    ],
)
def test_belief_in_a_way_lasts_where_the_wall_turns_the_fastest_wheel(
    fastest: float, forces: list[float], pitch_rad: float, rolls: bool
) -> None:
    world = World(pitch_rad)
    slower = [0.98, 0.95, 0.92, 0.95, 0.98]
    world.speeds = [fastest, *[each if fastest > 0 else -each for each in slower]]
    world.force, world.forces = 1.3, [*forces, 0.22, 0.22, 0.22, 0.22]
    world.drive(5)

    grown_m = world.drive(5)

    mean = sum(abs(each) for each in world.speeds) / 6
    least_m, mean_m = way_m(5, 0.8 * abs(fastest)), way_m(5, mean)
    may_be_off_m = 0.35 * (mean_m - least_m) if rolls else mean_m
    assert grown_m == pytest.approx(0.006 * mean_m + may_be_off_m, rel=1e-3 if rolls else 0.3)


@pytest.mark.parametrize(("force", "pull"), [(0.5, 0.75), (0.2, 1.0)])
def test_how_fast_a_robot_slides_follows_from_what_its_wheels_lack(
    force: float, pull: float
) -> None:
    world = slipping(World(UP))
    world.force = force
    world.drive(5)
    pull_m_s2 = pull * 9.81
    begun_m_s = world.sensing.distance.sliding_m_s

    first_m, second_m = world.drive(), world.drive()

    assert world.sensing.distance.sliding_m_s == pytest.approx(
        begun_m_s + 2 * ROUND_S * pull_m_s2, rel=0.02
    )
    assert second_m - first_m == pytest.approx(pull_m_s2 * ROUND_S**2, rel=0.02)


def test_what_was_decided_is_not_counted_again() -> None:
    world = slipping(World())
    world.force = 0.6
    world.drive(5)

    assert world.drive() == pytest.approx(world.drive())


@pytest.mark.parametrize(("running", "driving"), [(True, False), (False, True)])
def test_a_robot_may_have_driven_that_has_not_reported_its_rest(
    running: bool, driving: bool
) -> None:
    world = World()
    distance = world.sensing.distance._replace(running=running)
    asked = MotorRequest(setpoints(), 0.0, driving)

    sensing = world.sensing._replace(asked=asked, distance=distance)
    after = unheard(robot(), sensing, world.now_s + 1.0, nan)

    assert after.width_m > top_m_s()


def test_it_runs_until_no_wheel_has_a_share_any_more() -> None:
    world = World()
    world.drive(3)
    world.sensing = world.sensing._replace(asked=MotorRequest(setpoints(0.0), 0.0, False))
    world.drive()
    assert world.sensing.distance.running

    world.sensing = world.sensing._replace(
        asked=MotorRequest(setpoints(), 0.0, True), shares=(0.0,) * 6
    )
    world.drive()
    assert world.sensing.distance.running


def test_it_is_judged_when_that_is_due() -> None:
    world = World()
    world.now_s = world.sensing.distance.due_s
    world.judge()

    assert world.sensing.distance.at_s == world.now_s
    assert world.sensing.distance.due_s == world.now_s + world.sensing.distance.every_s


def test_wheels_that_are_not_driven_do_not_slip() -> None:
    world = slipping(World())
    world.force = 0.6
    world.duty = 0.0
    world.drive(5)

    assert world.drive(5) == pytest.approx(0.006 * way_m(5, 2.2 / 3))


@pytest.mark.parametrize(
    ("speeds", "off"),
    [
        ([0.77, 0.7, 0.7, 0.7, 0.7, 0.7], 0.07 / 6),
        ([0.98, 0.98, 0.98, 0.98, 1.0, 0.83], 0.13 / 6),
        ([0.79, SPEED, SPEED, SPEED, SPEED, SPEED], 0.01 / 6),
    ],
)
@pytest.mark.parametrize("travel", [1, -1])
def test_belief_in_the_mean_of_the_wheels_ends_as_far_as_most_of_them_show_another_way(
    speeds: list[float], off: float, travel: int
) -> None:
    """One wheel slips at the force at which the others of its part roll, or is held back."""
    world = World()
    world.speeds = [travel * each for each in speeds]

    # After 20 rounds the slowest wheel is 29 mm behind the others, and is not believed any more.
    world.drive(13)

    assert world.sensing.distance.out == set()
    rolled_m = way_m(13, sum(speeds) / 6)
    assert world.bound_m == pytest.approx(BASE_M + 0.006 * rolled_m + way_m(13, off), rel=0.02)


def test_most_wheels_that_differ_as_much_on_the_way_back_show_the_same_way_as_all() -> None:
    world = World()
    world.speeds[0] -= 0.01
    world.drive(20)
    world.speeds = [-each for each in world.speeds]
    world.drive(20)

    assert world.bound_m == pytest.approx(BASE_M + world.width_m)


def test_belief_in_the_mean_of_the_wheels_does_not_come_back_with_a_new_run() -> None:
    before = DistanceMemory(width_m=0.03, apart_m=-0.01)
    sensing = counting(robot(), nothing_known(robot()), before, read=True)

    assert sensing.numbers[robot().bound] == pytest.approx(BASE_M + 0.04)


def test_belief_in_a_wheel_that_shows_nothing_ends_before_it_is_known_to_be_dead() -> None:
    """It may have repeated its last report; then it has rolled on with the others."""
    world = World()
    world.duty = 0.9
    world.drive(5)
    world.speeds[0] = world.speeds[1] = 0.0

    world.drive(1)

    odometry_lacks_m = way_m(1) * 2 / 6
    may_have_rolled_m = 2 / 6 * 0.9 * top_m_s() * robot().link.period_s
    assert world.bound_m == pytest.approx(world.width_m + BASE_M + may_have_rolled_m)
    assert may_have_rolled_m > odometry_lacks_m
    world.drive(1)
    assert world.bound_m > world.width_m + BASE_M + 2 * odometry_lacks_m
    world.speeds[0] = world.speeds[1] = SPEED
    world.drive(1)
    assert world.bound_m < world.width_m + BASE_M + odometry_lacks_m, "they turn"


def test_belief_in_wheels_counts_whole_from_when_the_dead_ones_are_taken_out() -> None:
    """Their next reports are of a time in which they alone have shown the way."""
    world = World()
    world.speeds = [SPEED] * 3 + [0.0] * 3
    while not world.sensing.distance.out:
        world.drive()
    assert world.sensing.shares == pytest.approx((1 / 3,) * 3 + (0.0,) * 3)

    world.speeds = [SPEED] * 6
    while world.sensing.distance.out:
        world.drive()
    assert world.sensing.shares == pytest.approx((1 / 6,) * 6)


def test_belief_in_a_wheel_again_does_not_count_those_that_have_stopped_once_more() -> None:
    """After a stop only wheels count that have not reported since, each with what it had."""
    world = World()
    world.speeds = [SPEED] * 3 + [0.0] * 3
    while not world.sensing.distance.out:
        world.drive()
    world.speeds = [SPEED] * 6
    while world.sensing.distance.out == {3, 4, 5}:
        before = world.sensing
        world.drive()
    world.sensing = before._replace(
        shares=(0.0, 0.0, 1 / 3, 0.0, 0.0, 0.0),
        asked=MotorRequest(setpoints(0.0), world.now_s - ROUND_S, False),
    )
    world.now_s -= ROUND_S
    world.drive()

    assert world.sensing.distance.out != {3, 4, 5}
    assert world.sensing.shares == pytest.approx((0.0, 0.0, 1 / 3, 0.0, 0.0, 0.0))
