"""Said is not seen: what is declared is compared with the sensors before the first command."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from driving import BOTH_CLAMPED, DRIVING_FORWARD, IDLE, NEWT, PIRATE, REAR_CLAMPED, Driver, command

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.robot import declared_states
from pirate_sm.core._engine.robot.criteria import Sight
from pirate_sm.core._engine.robot.declared_states import Before, Look, LookResult, Watched
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    LAPSED,
    STOPPED,
    Mark,
    RobotState,
    at_rest_in,
)
from pirate_sm.core._model import events as ev

TURNS = {
    120: 2 * math.asin((0.120 - 0.048) / 0.09),
    113: 2 * math.asin((0.113 - 0.048) / 0.09),
    60: 2 * math.asin((0.060 - 0.048) / 0.09),
}


def held(mm: int = 113, borne: float = 0.6) -> dict[str, float]:
    """What a robot shows that holds on with both parts: spans, and torques on the springs."""
    angle = TURNS[mm]
    angles = {"gamma_1": -angle, "gamma_2": angle, "gamma_3": -angle, "gamma_4": angle}
    return angles | {f"bend_torque_{n}": borne if n % 2 == 0 else -borne for n in (1, 2, 3, 4)}


MISSION = """
start: go
phases:
  go: {do: [RelaxRear, DriveForward, Brake], go: out}
ends: {out: {succeed: Out}}
"""
HANDLED = "on_fault: [{fault: [sensor.silent, clamp.lost], then: continue}]\n"


def declared(drive, body: str = IDLE, states=BOTH_CLAMPED, **shown: float) -> Driver:
    """A robot that is said to be in these states and shows this, just after it began to look."""
    driver = drive(HANDLED + body, states=states, declared=True)
    driver.signals |= shown
    return driver


def left_open(driver: Driver) -> set[str]:
    """What is unconfirmed after the look, without the lights, which no sensor sees."""
    driver.run(3.2)
    assert driver.state.look is None
    return driver.unconfirmed - {"LightingState"}


def test_a_declared_clamp_is_unconfirmed_at_first(drive):
    driver = declared(drive, **held())

    assert {"FrontWheelsState", "RearWheelsState", "BendingState"} <= driver.unconfirmed


def test_a_clamp_that_is_not_there_refuses_the_start_before_anything_is_sent(drive):
    driver = declared(drive, MISSION)

    driver.run(3.2)

    assert driver.statuses == []
    assert driver.of(fx.Setpoints) == []
    assert driver.faults == [("start.contradicted", "stop")]
    message = driver.ended.message
    assert "the front part is declared to hold (BendingState DoubleClamped), but" in message
    assert "bend_torque_1, bend_torque_2 show 0, 0 mNm, less than 100 mNm" in message
    assert "--state" in message


@pytest.mark.parametrize(("borne", "faults"), [(0.12, []), (0.02, ["start.contradicted"])])
def test_a_clamp_that_a_grip_holds_by_the_least_is_left_open_and_a_slack_one_refused(
    drive, borne, faults
):
    # `careful` asks for 150 mNm at least, of which a loop may leave 30; nothing of other joints.
    shown = held(120) | {f"bend_torque_{n}": 0.0 for n in (2, 3)}
    driver = drive(HANDLED + IDLE, PIRATE, states=BOTH_CLAMPED, declared=True)
    driver.signals |= shown | {"bend_torque_1": -borne, "bend_torque_4": borne}

    driver.run(3.2)

    assert [code for code, _ in driver.faults] == faults


NOTHING_HELD = {"BendingState": "Unclamped"}
RESET = """
start: go
phases:
  go: {do: [{command: Reset, unneeded: skip}], go: out}
ends: {out: {succeed: Out}}
"""


def test_a_robot_that_holds_is_not_taken_for_one_that_holds_nothing_and_reset(drive):
    driver = declared(drive, RESET, NOTHING_HELD, **held())

    driver.run(3.2)

    assert driver.of(fx.Setpoints) == []
    assert driver.faults == [("start.contradicted", "stop")]
    assert "BendingState is declared Unclamped" in driver.ended.message
    assert "the front part bears 600, 600 mNm like one that holds" in driver.ended.message


SPANNING = held(120, borne=0.0)
"""A part stands in the pipe like one that holds, and bears nothing."""

IN_PIPE = "pipe: {diameter: 120 mm, segments: [{straight: 1 m}]}\n"


@pytest.mark.parametrize("borne", [0.12, 0.35])
@pytest.mark.parametrize(("apex", "way", "part"), [(1, -1, "front"), (4, 1, "rear")])
def test_a_robot_that_a_grip_holds_is_not_taken_for_one_that_holds_nothing(
    drive, borne, apex, way, part
):
    # The controls of experiment 3 hold by the apex alone, `careful` by no less than 150 - 30 mNm.
    shown = SPANNING | {f"bend_torque_{apex}": way * borne}
    driver = declared(drive, IN_PIPE + RESET, NOTHING_HELD, **shown)

    driver.run(3.2)

    assert driver.of(fx.Setpoints) == []
    assert driver.faults == [("start.contradicted", "stop")]
    told = f"the {part} part bears {borne * 1000:.0f} mNm at gamma_{apex}, with which it may hold"
    assert told in driver.ended.message
    assert "limit 100 mNm" in driver.ended.message


WEIGHT = {"bend_torque_1": -0.075, "bend_torque_4": 0.075}
"""What the outer links of a loose robot weigh at their joints, held out level: 75 mNm."""


@pytest.mark.parametrize(
    "shown",
    [
        pytest.param(SPANNING | WEIGHT, id="the weight of its outer links"),
        pytest.param(SPANNING | {"bend_torque_2": 0.3, "bend_torque_3": -0.3}, id="of a part"),
        pytest.param(SPANNING | {"bend_torque_1": 0.3, "bend_torque_4": -0.3}, id="it hangs"),
        pytest.param({"bend_torque_1": -0.3, "bend_torque_4": 0.3}, id="straight"),
        pytest.param(held(60, 0.3), id="smaller than the pipe"),
        pytest.param(held(120, 0.3) | {"gamma_1": math.nan, "gamma_4": math.nan}, id="no angle"),
        pytest.param(
            held(120, 0.3) | {"bend_torque_1": math.nan, "bend_torque_4": math.nan}, id="no torque"
        ),
    ],
)
def test_a_loose_robot_that_bears_its_own_weight_is_not_taken_for_one_that_holds(drive, shown):
    driver = declared(drive, IN_PIPE + RESET, NOTHING_HELD, **shown)

    driver.run(3.2)

    assert driver.ended is None
    assert ("Reset", "sent") in driver.statuses


@pytest.mark.parametrize("pipe", ["", IN_PIPE.replace("120", "55")], ids=["bench", "narrow pipe"])
def test_a_straight_part_bears_the_weight_of_a_robot_that_lies_on_its_ends(drive, pipe):
    # In the simulator 237 mNm, upright, with the apex 5 deg off.
    bent = {"gamma_1": -0.1, "gamma_2": 0.3, "bend_torque_1": -0.3}
    driver = declared(drive, pipe + RESET, NOTHING_HELD, **bent)

    driver.run(3.2)

    assert driver.faults == []
    assert ("Reset", "sent") in driver.statuses


def test_where_no_pipe_is_known_a_bent_part_that_bears_a_little_leaves_it_open(drive):
    # A robot on a bench that stands on its outer wheels like a bridge shows the same.
    driver = declared(drive, RESET, NOTHING_HELD, **SPANNING | {"bend_torque_1": -0.3})

    driver.run(3.2)

    assert driver.faults == []
    assert "BendingState" in driver.unconfirmed


def test_a_robot_on_the_bench_may_have_bent_joints(drive):
    bent = {name: value / 2 for name, value in held().items() if name.startswith("gamma")}
    driver = declared(drive, RESET, NOTHING_HELD, **bent)

    driver.run(3.2)

    assert driver.faults == []
    assert ("Reset", "sent") in driver.statuses


def test_a_clamp_that_the_sensors_show_is_confirmed_and_the_mission_begins(drive):
    driver = declared(drive, MISSION, **held())
    driver.run(0.5)
    assert driver.statuses == [], "it must last for half a second"

    driver.run(1.0)

    assert driver.unconfirmed == {"LightingState"}
    assert driver.statuses == [("RelaxRear", "sent")]
    told = [set(each.unconfirmed) for each in driver.of(fx.StateChange)]
    assert told[0] == set(driver.robot.regions)
    assert told[-1] == {"LightingState"}
    assert len(told) == len({frozenset(each) for each in told}), "each change is told once"


@pytest.mark.parametrize("name", ["gamma_1", "bend_torque_1", "bend_torque_3"])
def test_an_unknown_signal_is_no_agreement_and_no_contradiction(drive, name):
    driver = declared(drive, **(held() | {name: math.nan}))

    assert left_open(driver) == {"BendingState"}
    assert driver.ended is None
    assert "do not show whether" in driver.of(fx.Log)[-1].message


def test_a_clamp_that_is_left_open_neither_drives_nor_lets_go(drive):
    driver = declared(drive, **held(borne=0.3))
    assert left_open(driver) == {"BendingState"}

    for name in ("DriveForward", "RelaxRear"):
        command(driver, name)
        assert driver.last_status.status == "refused"
        assert driver.last_status.reason.startswith("impossible: no clamp")

    driver.signals |= held()
    command(driver, "ClampFront")
    driver.until_done("ClampFront")
    command(driver, "RelaxRear")
    assert driver.last_status.status == "sent", "the front has been seen to hold"


def test_torque_against_the_direction_of_the_clamp_is_none(drive):
    driver = declared(drive, **held(borne=-0.6))

    driver.run(3.2)

    assert driver.faults == [("start.contradicted", "stop")]


def test_a_joint_that_still_moves_shows_no_clamp(drive):
    driver = declared(drive, **held())
    driver.run(3.2, gamma_1=0.1)

    assert "BendingState" in driver.unconfirmed


def test_the_diameter_is_held_against_the_pipe(drive):
    pipe = "pipe: {diameter: 113 mm, segments: [{straight: 1 m}]}\n"
    fits = declared(drive, pipe + IDLE, **held())
    assert left_open(fits) == set()

    other = declared(drive, pipe + IDLE, **held(60))
    other.run(3.2)
    assert "diameter_front shows 60 mm, the pipe has 113 mm, limit 15% off" in other.ended.message


def test_without_a_pipe_held_parts_must_agree_and_touch_a_wall(drive):
    bent = {name: value for name, value in held(60).items() if name in ("gamma_3", "gamma_4")}
    unequal = declared(drive, **(held() | bent))
    unequal.run(3.2)
    assert "diameter_front shows 113 mm, diameter_rear 60 mm" in unequal.ended.message

    stop = max(each.open_rad for each in unequal.robot.sight.parts if each)
    opened = declared(drive, **(held() | {"gamma_4": stop + 0.01}))
    opened.run(3.2)
    assert "it has opened to its end stop" in opened.ended.message


def test_wheels_that_turn_refuse_the_start_and_are_stopped(drive):
    driver = declared(drive, **held())

    driver.run(3.2, theta_2=3.0)

    assert driver.faults == [("start.contradicted", "stop")]
    assert "omega_2 shows 3.00 rad/s, limit 0.3 rad/s" in driver.of(fx.Fault)[0].message
    duties = {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    assert driver.nonzero == pytest.approx(duties)


def test_wheels_of_a_robot_of_which_nothing_is_declared_are_stopped_too(drive):
    driver = drive(HANDLED + IDLE, declared=True)

    driver.run(3.2, theta_2=3.0)

    assert driver.faults == [("start.contradicted", "stop")]
    assert not driver.ended, "the safe array is awaited"
    assert driver.in_flight
    driver.accept()
    assert driver.ended.outcome == "fault"


@pytest.mark.parametrize(("lapse_s", "open_"), [(0.0, set()), (0.2, {"front"})])
def test_belief_in_a_clamp_takes_a_whole_half_second_of_agreement(drive, lapse_s, open_):
    driver = declared(drive, **held())
    driver.run(0.4)
    if lapse_s:
        driver.signals["bend_torque_1"] = math.nan
        driver.run(0.4 + lapse_s)
        driver.signals |= held()
    driver.run(0.85)

    parts = driver.robot.parts
    assert {parts[mark.which] for mark in driver.state.robot.marks if mark.kind == "part"} == open_


def test_a_contradiction_that_has_not_lasted_at_the_end_of_the_look_leaves_it_open(drive):
    driver = declared(drive, **(held() | {"bend_torque_3": math.nan}))
    driver.run(2.8)
    driver.signals |= {"bend_torque_3": 0.0, "bend_torque_4": 0.0}

    assert left_open(driver) == {"BendingState"}
    assert "start.contradicted" not in dict(driver.faults)


def test_a_comparison_is_decided_when_it_has_lasted_and_no_frame_comes(drive):
    driver = declared(drive, **held())
    driver.run(0.4)
    since_s = {each.agrees_s for each in driver.state.look.marks}
    assert driver.state.look.due_s == pytest.approx(min(since_s) + 0.5)
    assert driver.wake_at <= driver.state.look.due_s

    driver.tick(max(since_s) + 0.49)
    assert "BendingState" in driver.unconfirmed
    driver.tick(max(since_s) + 0.5)
    assert driver.unconfirmed == {"LightingState"}


def test_of_each_part_one_wheel_must_be_heard(drive):
    one = declared(drive, **held(), theta_1=math.nan)
    assert left_open(one) == set()

    deaf = declared(drive, **held(), theta_4=math.nan, theta_5=math.nan, theta_6=math.nan)
    assert left_open(deaf) == {"RearWheelsState"}


def test_driving_that_is_declared_is_only_what_a_command_can_confirm(drive):
    driver = declared(drive, states=DRIVING_FORWARD, **held())
    assert left_open(driver) == {"FrontWheelsState", "RearWheelsState"}

    command(driver, "ToggleLighting")
    assert not any(driver.array[f"wheel_{n}"] for n in range(1, 7)), "no other command drives"
    driver.until_done("ToggleLighting")
    command(driver, "DriveForward")
    driver.until_done("DriveForward")
    assert driver.unconfirmed == set()


def test_wheels_that_turn_the_other_way_contradict_driving(drive):
    driver = declared(drive, states=DRIVING_FORWARD, **held())

    driver.run(3.2, theta_1=-3.0)

    assert "omega_1 shows -3.00 rad/s, the other way" in driver.of(fx.Fault)[0].message


def test_an_angle_that_is_declared_and_is_not_there_refuses_the_start(drive):
    driver = declared(drive, states=REAR_CLAMPED | {"RotationState": "AlignedLeft"}, **held())

    driver.run(3.2)

    assert "RotationState is declared AlignedLeft, but phi shows 0 deg, not -90 deg" in (
        driver.ended.message
    )


def test_a_contradiction_that_goes_in_time_is_none(drive):
    driver = declared(drive)
    driver.run(2.0)

    driver.signals |= held()
    driver.run(3.2)

    assert driver.ended is None
    assert driver.unconfirmed == {"LightingState"}


def test_no_command_of_the_operator_is_taken_while_the_sensors_are_looked_at(drive):
    driver = declared(drive, **held())
    driver.run(0.2)

    command(driver, "RelaxRear")

    assert "still being compared" in driver.last_status.reason


def test_an_end_while_the_sensors_are_looked_at_ends(drive):
    driver = declared(drive, states={})

    driver.give(ev.Abort("enough"), 0.1)

    assert driver.ended.outcome == "interrupted"
    assert driver.of(fx.Setpoints) == []


def test_a_fault_before_the_first_command_actuates_no_declared_clamp(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED, declared=True)

    driver.give(ev.FaultReport("link.lost", "gone"), 0.1)

    assert driver.ended.outcome == "fault"
    assert driver.of(fx.Setpoints) == []


def test_nothing_is_looked_at_any_more_once_it_is_decided(drive):
    driver = declared(drive, **held())
    driver.run(1.0)

    assert driver.state.look is None


def test_on_paper_what_is_declared_is_so(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED, declared=True, nominal=True)

    assert driver.unconfirmed == set()
    assert driver.state.look is None


def test_where_the_profile_says_nothing_all_stays_open_and_nothing_is_waited_for(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    silent = Driver(replace(driver.robot, sight=Sight()), driver.engine.program, declared=True)

    assert silent.state.look is None
    assert silent.unconfirmed == set(silent.robot.regions)
    assert [each.phase for each in silent.of(fx.WaitArmed)] == ["idle"]


def test_a_robot_of_another_make_is_looked_at_too(drive):
    states = {"Grip": "BothHeld"}
    driver = drive(IDLE, robot=NEWT, states=states, declared=True)

    driver.run(3.2)

    assert "the nose part is declared to hold (Grip BothHeld)" in driver.ended.message


class TestExactly:
    """What is compared, and what an echo confirms, without an engine around it."""

    @pytest.fixture
    def robot(self, drive) -> RobotSpec:
        return drive(IDLE, states=BOTH_CLAMPED).robot

    @staticmethod
    def body_in(robot: RobotSpec, states: dict[str, str], *marks: Mark) -> RobotState:
        found = next(
            at
            for at, names in enumerate(robot.table.configurations)
            if states.items() <= dict(zip(robot.regions, names, strict=True)).items()
        )
        return at_rest_in(robot, found)._replace(marks=frozenset(marks))

    def region(self, robot: RobotSpec, name: str, command: int = DECLARED) -> Mark:
        return Mark("region", robot.regions.index(name), command)

    def test_a_declared_robot_is_not_driven_whatever_is_declared(self, robot):
        driving = self.body_in(robot, DRIVING_FORWARD)
        assert any(driving.values[slot] for slot in robot.safe_zero)

        body = declared_states.declared_in(robot, driving.configuration)

        wheels = set(robot.safe_zero)
        assert body.values == tuple(
            0.0 if slot in wheels else value for slot, value in enumerate(driving.values)
        )
        assert body.marks == {
            *(Mark("part", part, DECLARED) for part in (0, 1)),
            *(self.region(robot, name) for name in robot.regions),
            *(self.region(robot, f"{end}WheelsState", STOPPED) for end in ("Front", "Rear")),
        }

    def test_only_declared_states_that_sensors_can_show_are_compared(self, robot):
        light = self.region(robot, "LightingState")
        front = self.region(robot, "FrontWheelsState")
        others = [front._replace(command=each) for each in (STOPPED, DENIED, LAPSED, 3)]
        body = self.body_in(robot, BOTH_CLAMPED, front, light, *others)

        look = declared_states.begin(robot, body, 10.0)

        assert [each.mark for each in look.marks] == [front]
        assert look.until_s == 10.0 + robot.sight.within_s
        assert look.setpoints == at_rest_in(robot, body.configuration).values
        assert look.before is None

    def test_what_no_sensor_can_show_is_compared_only_after_an_interruption(self, robot, drive):
        body = self.body_in(robot, BOTH_CLAMPED, self.region(robot, "LightingState"))
        before = Before(drive(IDLE).state.sensing, body, 2.0, resumes=False)

        assert declared_states.begin(robot, body, 10.0) is None
        look = declared_states.begin(robot, body, 10.0, before)
        assert (look.marks, look.before) == ((), before)

    def test_a_part_whose_sensors_were_not_known_is_looked_at_without_an_end(self, robot):
        front, rear = Mark("part", 0, LAPSED), Mark("part", 1, LAPSED)
        declared = Mark("part", 1, DECLARED)
        body = self.body_in(robot, BOTH_CLAMPED, front, declared)

        first = declared_states.seen_again(robot, None, body)
        assert first.until_s == math.inf
        assert first.marks == (Watched(front),)
        seen = first._replace(marks=(Watched(front, agrees_s=9.0),))
        later = declared_states.seen_again(
            robot, seen, body._replace(marks=frozenset({front, rear}))
        )
        assert later.marks == (Watched(front, agrees_s=9.0), Watched(rear))
        nothing = body._replace(marks=frozenset({declared}))
        assert declared_states.seen_again(robot, first, nothing) is None

    def test_an_echo_confirms_only_what_is_declared_and_has_no_other_sensor(self, robot):
        light, front = self.region(robot, "LightingState"), self.region(robot, "FrontWheelsState")
        body = self.body_in(robot, BOTH_CLAMPED, light, front)

        assert declared_states.awaiting(robot, body) == {light}
        assert declared_states.accepted(robot, body).marks == {front}
        toggling = body._replace(marks=frozenset({light._replace(command=3)}))
        assert declared_states.awaiting(robot, toggling) == frozenset()
        assert declared_states.accepted(robot, toggling) is toggling

    @pytest.mark.parametrize(("how", "confirmed"), [("set", False), ("keep", True)])
    def test_an_array_that_sets_it_otherwise_confirms_nothing(self, robot, how, confirmed):
        light = self.region(robot, "LightingState")
        body = self.body_in(robot, BOTH_CLAMPED | {"LightingState": "On"}, light)
        assert declared_states.accepted(robot, body).marks == frozenset()
        actuation = list(robot.actuation)
        *others, last = body.stages(robot, light.which, "On")
        changed = tuple(write._replace(how=how, value=write.value + 1.0) for write in last)
        actuation[light.which] = dict(actuation[light.which]) | {"On": (*others, changed)}
        robot = replace(robot, actuation=tuple(actuation))

        assert (not declared_states.accepted(robot, body).marks) == confirmed

    def test_only_parts_that_are_declared_are_left_open(self, robot):
        marks = (
            Mark("part", 0, DENIED),
            Mark("part", 1, DECLARED),
            self.region(robot, "BendingState"),
        )
        body = self.body_in(robot, BOTH_CLAMPED, *marks)

        assert declared_states.parts_left_open(robot, body) == ("rear",)


class TestLookingAtAStrangeRobot:
    """A robot whose clamps are seen to hold, but that seems to be another one."""

    FOR_S = 0.5

    @pytest.fixture
    def holding(self, drive) -> Driver:
        driver = declared(drive, **held())
        driver.run(0.2)
        assert driver.state.look is not None
        return driver

    def look(self, driver: Driver, before: Look, now: float, *strange: str, marks=None):
        body = driver.state.robot
        body = body if marks is None else body._replace(marks=frozenset(marks))
        numbers = driver.state.sensing.numbers
        return declared_states.look(driver.robot, before, body, numbers, None, now, strange)

    def begun(self, driver: Driver) -> Look:
        return declared_states.begin(driver.robot, driver.state.robot, 10.0)

    def test_nothing_is_confirmed_until_it_is_known_again_or_known_to_be_another(self, holding):
        assert max(each.for_s for each in holding.robot.sight.parts) == self.FOR_S
        first = self.look(holding, self.begun(holding), 10.0, "moved")
        assert (first.confirmed, first.contradictions) == (frozenset(), ())
        assert first.look.strange_s == 10.0
        later = self.look(holding, first.look, 10.4, "moved")
        assert later.confirmed == frozenset()

        another = self.look(holding, later.look, 10.5, "moved")
        assert (another.look, another.confirmed) == (None, frozenset())
        assert another.contradictions == ("moved",)
        known = self.look(holding, later.look, 10.5)
        assert known.look is not None
        assert math.isnan(known.look.strange_s)

    def test_without_strangeness_clamps_are_confirmed_once_they_were_seen_long_enough(
        self, holding
    ):
        first = self.look(holding, self.begun(holding), 10.0)
        assert not {mark for mark in first.confirmed if mark.kind == "part"}

        later = self.look(holding, first.look, 10.5)
        assert {mark.which for mark in later.confirmed if mark.kind == "part"} == {0, 1}

    def test_a_robot_of_which_all_is_confirmed_is_looked_at_while_it_is_strange(self, holding):
        empty = self.begun(holding)._replace(marks=())

        assert self.look(holding, empty, 10.0, "moved").look is not None
        assert self.look(holding, empty, 10.0).look is None

    def test_what_a_command_has_confirmed_meanwhile_is_decided(self, holding):
        result = self.look(holding, self.begun(holding), 10.0, marks=())

        assert result == LookResult(None, frozenset())
