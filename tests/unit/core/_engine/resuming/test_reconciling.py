"""What the sensors show is compared with where the robot may be: rules 1 and 6."""

from __future__ import annotations

from dataclasses import replace
from math import isnan, nan
from types import SimpleNamespace

import pytest
from cut_off import GRIPPING, CutOff, verdict_of
from driving import (
    BOTH_CLAMPED,
    DRIVING_FORWARD,
    FRONT_CLAMPED,
    IDLE,
    REAR_CLAMPED,
    changed_newt,
    command,
)

from pirate_sm.core._engine.resuming.hypotheses import hypotheses
from pirate_sm.core._engine.resuming.reconciling import _Course, adoptable, reconcile, turning
from pirate_sm.core._engine.robot.declared_states import declared_in
from pirate_sm.core._engine.robot.robot_state import DECLARED, DENIED, Mark, states_of
from pirate_sm.core._engine.sensing.board_spec import DerivedSpec
from pirate_sm.core._engine.unwatched import changed
from pirate_sm.core._model.events import FaultReport, SensorFrame
from pirate_sm.core.loading import load_robot

CONFIRMED, CONTRADICTED, UNKNOWN = "confirmed", "contradicted", "unknown"


@pytest.fixture
def clamped(drive):
    """A robot at rest, both parts clamped, whose run is cut off."""
    return CutOff(at_rest(drive(IDLE, states=BOTH_CLAMPED)))


def at_rest(driver):
    driver.signals |= GRIPPING
    driver.run(2.0)
    return driver


def test_parts_that_bear_and_span_are_confirmed(clamped):
    found = clamped.look()

    assert not found.refusals
    assert found.chosen is found.tables[0]
    assert [verdict_of(found, part).word for part in ("front", "rear")] == [CONFIRMED] * 2
    assert verdict_of(found, "FrontWheelsState").word == CONFIRMED


def test_a_table_says_what_was_recorded_what_is_seen_and_the_limit(clamped):
    shown = verdict_of(clamped.look(bend_torque_1=-0.6), "front").shown

    assert shown[0].signal == "bend_torque_1"
    assert (shown[0].recorded, shown[0].seen) == ("-700 mNm", "-600 mNm")
    assert "495 mNm" in shown[0].limit, "70 % of what its motor bears at 70 %"


@pytest.mark.parametrize("signal", ["bend_torque_1", "gamma_1", "gamma_2"])
def test_a_sensor_without_value_confirms_nothing_and_contradicts_nothing(clamped, signal):
    found = clamped.look(**{signal: nan})

    assert verdict_of(found, "front").word == UNKNOWN
    assert found.chosen is not None


@pytest.mark.parametrize(("frames", "word"), [(1, UNKNOWN), (4, UNKNOWN), (8, CONFIRMED)])
def test_belief_in_a_clamp_takes_more_than_one_frame(clamped, frames, word):
    clamped.driver.signals |= {"bend_torque_1": nan, "bend_torque_2": nan}
    for turn in range(20):
        if turn == 20 - frames:
            clamped.driver.signals |= GRIPPING
        clamped.frames += [
            (10.0 + turn / 10, clamped.driver.frame(board)) for board in clamped.robot.boards
        ]

    found = reconcile(
        clamped.robot, clamped.program, clamped.last, clamped.frames, 11.9, clamped.driven_s
    )

    assert verdict_of(found, "front").word == word
    assert verdict_of(found, "rear").word == CONFIRMED


def turns(cut: CutOff, count: int, at_last: dict[str, float]) -> None:
    """The boards report this often, each tenth of a second; the last frames show something else."""
    for turn in range(count):
        if turn == count - 1:
            cut.driver.signals |= at_last
        cut.frames += [(10.0 + turn / 10, cut.driver.frame(board)) for board in cut.robot.boards]


@pytest.mark.parametrize(
    "shown", [{"bend_torque_1": 0.0, "bend_torque_2": 0.0}, {"acc_z": 0.0}], ids=["slack", "fallen"]
)
def test_what_one_frame_shows_contradicts_nothing(clamped, shown):
    turns(clamped, 20, shown)

    found = reconcile(clamped.robot, clamped.program, clamped.last, clamped.frames, 11.9, 0.0)

    assert verdict_of(found, "front").word != CONTRADICTED
    assert not any("robot.fallen" in each for each in found.refusals)
    assert found.chosen is not None


def test_boards_that_have_fallen_silent_before_the_end_of_a_look_show_nothing(clamped):
    turns(clamped, 20, {})

    found = reconcile(clamped.robot, clamped.program, clamped.last, clamped.frames, 20.0, 0.0)

    for about in ("front", "rear", "FrontWheelsState"):
        assert verdict_of(found, about).word == UNKNOWN
    assert len(found.refusals) == len(clamped.robot.boards)
    assert all(isnan(found.numbers[wheel.angle]) for wheel in clamped.robot.wheels)


def test_a_board_is_silent_once_its_signals_are_old(clamped):
    clamped.frames = [(10.0, clamped.driver.frame(board)) for board in clamped.robot.boards]
    stale_s = clamped.robot.link.stale_after_s

    def silent(now_s: float) -> bool:
        found = reconcile(clamped.robot, clamped.program, clamped.last, clamped.frames, now_s, 0.0)
        return any("does not report" in each for each in found.refusals)

    assert not silent(10.0 + 0.9 * stale_s)
    assert silent(10.0 + stale_s)


def test_joints_of_a_robot_that_was_driven_may_have_moved(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    command(driver, "DriveForward")
    driver.accept()
    driver.run(4.0, theta_1=3.0, theta_2=-3.0)
    last = driver.state
    driver.state = last._replace(robot=last.robot._replace(motion=None))

    assert any("gamma_2" in each for each in CutOff(driver).look(gamma_2=1.2).refusals)
    assert not any(
        "gamma_2" in each for each in CutOff(driver, driven_s=0.4).look(gamma_2=1.2).refusals
    )


def test_other_places_than_the_recorded_one_may_be_looked_at(clamped):
    declared = clamped.recorded.body.configuration
    where = adoptable(clamped.robot, declared)
    turns(clamped, 20, {})

    found = reconcile(
        clamped.robot, clamped.program, clamped.last, clamped.frames, 11.9, 0.0, found=where
    )

    assert [each.hypothesis.name for each in found.tables] == ["adopted"] * len(where)


def test_a_place_is_judged_among_many_as_it_is_alone(clamped):
    """Places whose setpoints change no signal share what the boards have shown."""
    where = adoptable(clamped.robot, clamped.recorded.body.configuration)
    turns(clamped, 20, {})
    look = clamped.robot, clamped.program, clamped.last, clamped.frames, 11.9, 0.0

    tables = reconcile(*look, found=where).tables

    for place, table in list(zip(where, tables, strict=True))[::4]:
        assert reconcile(*look, found=(place,)).tables == (table,)


ANOTHER_DUTY = [
    ("Grip in (NoseHeld, BothHeld)", "Grip in (NoseHeld, NoseBack, BothHeld)"),
    (", senses: angle, slot: fold_neck", ""),
    ("    NoseHeld: {fold", "    NoseBack: {fold_neck: 50 %, fold_hip: 0 %}\n    NoseHeld: {fold"),
    (
        "  HoldNose:\n",
        "  Back:\n    asks_for: Grip == NoseBack\n"
        "    done: {kind: below, signals: [neck], limit: 6 deg, for: 0.2 s}\n"
        "    timeout: 8 s\n    nominal: 2 s\n  HoldNose:\n",
    ),
    (
        "      NoseHeld: {kind",
        "      NoseBack: {kind: accepted, why: a worm locks it}\n      NoseHeld: {kind",
    ),
]
BACK = """\
              - {event: Back, target: Grip.NoseBack}
          Grip.NoseBack:
            transitions:
              - {event: Home, target: Grip.Loose}
          Grip.NoseHeld:
"""


def test_a_part_that_holds_by_another_duty_is_judged_for_itself(tmp_path):
    """No signal reads the duty of a joint whose torque and angle have channels of their own."""
    changed_newt(tmp_path, *ANOTHER_DUTY)
    chart = tmp_path / "newt" / "chart.yaml"
    text = chart.read_text("utf-8").replace("          Grip.NoseHeld:\n", BACK, 1)
    chart.write_text(text, "utf-8")
    robot = load_robot(tmp_path / "newt").oriented("normal")
    shown = {"neck": -1.6, "neck_torque": -0.5, "hip": 1.2}  # what NoseHeld shows
    frames = []
    for at_s in (0.05 * turn for turn in range(40)):
        for board in sorted(robot.boards.values(), key=lambda each: each.position):
            values = [0.0] * board.length
            for place, target, scale in board.channels:
                values[place] = shown.get(robot.vocabulary.numbers[target], 0.0) / scale
            frames.append((at_s, SensorFrame(board.id, tuple(values))))
    program = SimpleNamespace(diameter_m=None)
    mark = Mark("part", robot.parts.index("nose"), DECLARED)

    def bodies(*grips):
        for grip in grips:
            there = robot.table.configurations.index((grip, "Resting", "Dark"))
            yield declared_in(robot, there)

    for grips in (("NoseHeld", "NoseBack"), ("NoseBack", "NoseHeld")):
        first, second = bodies(*grips)
        course = _Course(robot, program, first, frames, 2.0)
        found = {
            grip: course._judged(body, mark).is_confirmed(2.0)
            for grip, body in zip(grips, (first, second), strict=True)
        }
        assert found == {"NoseHeld": True, "NoseBack": False}


def test_a_wheel_turns_from_the_limit_on(clamped):
    speed = clamped.robot.wheels[0].speed
    limits = {
        sign.bound.limit
        for states in clamped.robot.sight.states
        for spec in states.values()
        for sign in spec.signs
        if spec.kind == "stopped" and sign.bound.signal == speed
    }
    numbers = [0.0] * len(clamped.robot.vocabulary.numbers)

    def turns_at(speed_rad_s: float) -> bool:
        numbers[speed] = speed_rad_s
        return turning(clamped.robot, tuple(numbers))

    (limit,) = limits
    assert turns_at(limit)
    assert turns_at(-limit)
    assert not turns_at(0.99 * limit)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_robot_that_lies_exactly_as_before_has_not_turned(clamped, sign):
    """Rounding makes the cosine of no angle larger than 1 for these."""
    numbers = list(clamped.last.sensing.numbers)
    before, after = list(numbers), list(numbers)
    for board in clamped.robot.boards.values():
        for source in (each for sources in board.vectors for each in sources):
            before[source], after[source] = 0.1, sign * 0.1

    found = tuple(changed(clamped.robot, tuple(before), frozenset(), tuple(after)))

    assert bool(found) == (sign < 0)


def test_only_accelerations_show_how_a_robot_lies(clamped):
    """The norm of three numbers of a board, such as angles and torques, has no direction."""
    robot, numbers = clamped.robot, list(clamped.last.sensing.numbers)
    board = next(board for board in robot.boards.values() if not board.vectors)
    others = board.numbers[:3]
    turned = replace(board, derived=(*board.derived, DerivedSpec("norm", -1, others)))
    robot = replace(robot, boards={board.id: turned})
    for place, other in enumerate(others):
        numbers[other] = float(place)

    assert turned.vectors
    assert not tuple(changed(robot, tuple(numbers), frozenset(), tuple(-n for n in numbers)))


def test_belief_in_an_earlier_look_ends_where_a_later_one_shows_something_else(clamped):
    first = clamped.look(theta_1=1.0)
    later = CutOff(clamped.driver)

    def again(**signals: float) -> bool:
        found = later.look(**signals)
        later.frames.clear()
        return found.is_as(first, clamped.robot)

    assert again()
    assert again(theta_1=1.0 + 0.5 * clamped.robot.sight.dark.agree_m / 0.024)
    assert not again(theta_1=1.0 + 1.5 * clamped.robot.sight.dark.agree_m / 0.024)
    assert not again(theta_1=1.0 - 1.5 * clamped.robot.sight.dark.agree_m / 0.024)
    assert again(theta_1=1.0)
    assert not again(bend_torque_1=-0.3)
    assert not again(bend_torque_1=-0.7, acc_z=0.0)


def test_a_light_is_unknown_since_nothing_sees_it(clamped):
    assert verdict_of(clamped.look(), "LightingState").word == UNKNOWN


def test_slack_springs_contradict_a_clamp_and_refuse(clamped):
    found = clamped.look(bend_torque_1=0.0, bend_torque_2=0.0)

    assert verdict_of(found, "front").word == CONTRADICTED
    assert found.chosen is None
    assert found.refusals == (
        "front was recorded as holds, but bend_torque_1, bend_torque_2 show 0, 0 mNm,"
        " less than 100 mNm",
    )


def test_a_joint_that_is_stuck_elsewhere_refuses(clamped):
    found = clamped.look(gamma_1=0.0)

    assert any("gamma_1 of the front part shows 0.0 deg" in each for each in found.refusals)


def test_a_clamped_joint_that_has_moved_by_more_than_five_degrees_refuses(clamped):
    assert not clamped.look(gamma_2=1.0 + 0.08).refusals
    assert any("gamma_2" in each for each in clamped.look(gamma_2=1.0 + 0.10).refusals)


def test_a_robot_that_lies_otherwise_refuses(clamped):
    found = clamped.look(acc_z=9.81 * 0.94, acc_y=9.81 * 0.34)

    assert found.refusals == ("the robot lies 20 deg otherwise than before, limit 15 deg",)


def test_a_fallen_robot_refuses(clamped):
    found = clamped.look(acc_z=0.0)

    assert "robot.fallen: the robot is falling or sliding freely" in found.refusals


def test_a_board_that_does_not_report_refuses(clamped):
    clamped.silent = frozenset({24})

    assert clamped.look().refusals == ("board 24 (rotation) does not report",)


def test_a_robot_that_was_moved_by_hand_is_asked_about(clamped):
    clamped.driver.signals |= {f"theta_{number}": 20.0 for number in range(1, 7)}
    clamped.driver.run(3.0)
    moved = CutOff(clamped.driver)

    found = moved.look(**{f"theta_{number}": 20.0 + 0.05 / 0.024 for number in range(1, 7)})

    assert "wheels have rolled" in found.questions[0]
    assert "50" in found.questions[0]
    assert not found.way.exact


def test_another_diameter_contradicts(drive):
    pipe = "pipe: {format: 1, diameter: 91 mm, segments: [{straight: 2 m}]}\n"
    driver = at_rest(drive(pipe + IDLE, states=BOTH_CLAMPED))

    found = CutOff(driver).look(gamma_1=-1.4, gamma_2=1.4)

    assert any(
        "diameter_front shows" in each and "limit 15% off" in each for each in found.refusals
    )


def test_what_the_recording_contradicts_itself_is_left_to_a_command(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.signals |= GRIPPING | {"bend_torque_1": 0.0, "bend_torque_2": 0.0}
    driver.run(2.0)

    found = CutOff(driver).look()

    front = verdict_of(found, "front")
    assert (front.word, front.why) == (UNKNOWN, "it is contradicted in the recording already")
    assert clamps_of(found)[0].command == DENIED
    assert found.chosen is not None
    assert verdict_of(found, "LightingState").why == (
        "nothing measures it; the first accepted array that holds it confirms it"
    )


def test_a_command_that_may_have_begun_to_drive_leaves_the_way_open(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    command(driver, "DriveForward")
    assert driver.in_flight

    way = CutOff(driver, driven_s=0.4).look().way

    assert way.low_m == -way.high_m < 0.0
    assert CutOff(driver).look().way.exact


def test_why_a_state_is_unknown(drive):
    driver = at_rest(drive(IDLE, states=REAR_CLAMPED))
    command(driver, "ClampFront")
    driver.accept()
    found = CutOff(driver).look(bend_torque_1=-0.3, bend_torque_4=0.3)

    assert verdict_of(found, "front").why == "ClampFront was not done when the recording ends"
    assert verdict_of(found, "rear").why == (
        "the sensors show it neither so nor otherwise for long enough"
    )


def test_wheels_that_turn_are_stopped_first(clamped):
    clamped.driver.signals["theta_1"] = 0.0
    robot, driver = clamped.robot, clamped.driver
    for turn in range(11):
        driver.signals["theta_1"] = 0.1 * turn
        at_s = 10.0 + turn / 10
        clamped.frames += [(at_s, driver.frame(board)) for board in robot.boards]
    found = reconcile(robot, clamped.program, clamped.last, clamped.frames, 11.0, 0.0)

    assert found.turning


def test_driven_wheels_that_stand_are_unknown(drive):
    driver = at_rest(drive(IDLE, states=DRIVING_FORWARD))
    command(driver, "DriveForward")

    found = CutOff(driver).look()

    assert verdict_of(found, "FrontWheelsState").word == UNKNOWN
    assert not found.turning


class TestACommandSentLast:
    @pytest.fixture
    def relaxing(self, drive):
        """The rear is told to relax, and nobody has recorded whether that was accepted."""
        driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
        command(driver, "RelaxRear")
        assert driver.in_flight
        return CutOff(driver)

    def test_there_are_two_hypotheses(self, relaxing):
        found = relaxing.look()

        bending = [states_of(relaxing.robot, each.hypothesis.body)[2] for each in found.tables]
        assert bending == ["DoubleClamped", "FrontClampedRearRelaxed"]
        assert [each.hypothesis.command for each in found.tables] == ["", "RelaxRear"]

    def test_a_rear_that_is_seen_to_hold_was_not_relaxed(self, relaxing):
        found = relaxing.look()

        assert found.chosen is found.tables[0]

    def test_a_slack_rear_was_relaxed(self, relaxing):
        found = relaxing.look(bend_torque_3=0.0, bend_torque_4=0.0)

        assert found.chosen is found.tables[1]

    def test_a_slack_front_contradicts_both(self, relaxing):
        found = relaxing.look(bend_torque_1=0.0, bend_torque_2=0.0)

        assert found.chosen is None
        assert not found.choices
        assert found.refusals


@pytest.mark.parametrize("states", [DRIVING_FORWARD, BOTH_CLAMPED])
@pytest.mark.parametrize("wheels", ["seen", "not seen"])
def test_wheels_that_stand_say_nothing_about_the_last_command(drive, states, wheels):
    """They are stopped before the look: "Brake accepted" was taken for true, without a record."""
    driver = at_rest(drive(IDLE, states=states))
    command(driver, "Brake" if states == DRIVING_FORWARD else "DriveForward")
    assert driver.in_flight
    before = CutOff(driver)
    unseen = {f"theta_{n}": nan for n in range(1, 7)} if wheels == "not seen" else {}

    found = before.look(**unseen)

    assert [each.hypothesis.name for each in found.tables] == ["recorded", "sent"]
    assert found.chosen is found.tables[0]


def test_a_brake_that_was_accepted_is_recorded(drive):
    driver = at_rest(drive(IDLE, states=DRIVING_FORWARD))
    command(driver, "Brake")
    driver.accept()

    found = CutOff(driver).look()

    assert found.chosen is found.tables[-1]
    assert verdict_of(found, "FrontWheelsState").word == CONFIRMED


def test_a_light_that_may_have_been_toggled_a_person_must_see(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    command(driver, "ToggleLighting")

    found = CutOff(driver).look()

    assert not found.refusals
    assert found.chosen is None
    assert found.choices == found.tables


def test_a_part_whose_command_was_under_way_is_not_contradicted(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.signals |= GRIPPING | {"bend_torque_3": 0.0, "bend_torque_4": 0.0}
    driver.run(2.0)
    command(driver, "ClampRear")
    driver.accept()

    found = CutOff(driver).look()

    rear = verdict_of(found, "rear")
    assert (rear.word, rear.why) == (UNKNOWN, "ClampRear was not done when the recording ends")


def test_joints_may_have_moved_by_a_command_that_was_under_way(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    driver.signals |= GRIPPING | {"bend_torque_3": 0.0, "bend_torque_4": 0.0}
    driver.run(2.0)
    at_rest = CutOff(driver)
    command(driver, "ClampRear")
    driver.accept()
    under_way = CutOff(driver)

    assert any("gamma_2" in each for each in at_rest.look(gamma_2=1.2).refusals)
    assert not any("gamma_2" in each for each in under_way.look(gamma_2=1.2).refusals)


def test_what_the_recording_contradicts_and_the_sensors_show_now_may_be_confirmed(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.signals |= GRIPPING | {"bend_torque_1": 0.0, "bend_torque_2": 0.0}
    driver.run(2.0)

    found = CutOff(driver).look(**GRIPPING)

    assert verdict_of(found, "front").word == CONFIRMED
    front = clamps_of(found)[0]
    assert front.command == DECLARED


def test_the_joints_of_a_part_that_was_denied_may_have_moved(clamped):
    message = "the front has opened nearly to its end stop, there is no wall"
    clamped.driver.give(FaultReport("clamp.lost", message))
    denied = CutOff(clamped.driver)

    assert not any("gamma_2" in each for each in denied.look(gamma_2=1.2).refusals)
    assert any("gamma_3" in each for each in denied.look(gamma_3=-1.2).refusals)


def test_a_clamp_that_a_fault_denied_stays_denied(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    message = "the front has opened nearly to its end stop, there is no wall"
    driver.give(FaultReport("clamp.lost", message))
    cut = CutOff(driver)
    assert any(mark.command == DENIED for mark in cut.last.robot.marks)

    found = cut.look()

    assert clamps_of(found)[0].command == DENIED


def clamps_of(found):
    """The marks of the parts, from the front."""
    marks = found.tables[0].hypothesis.body.marks
    return sorted(mark for mark in marks if mark.kind == "part")


def test_a_command_that_only_the_caller_knows_of_is_a_hypothesis_too(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    robot, program = driver.robot, driver.engine.program
    relax = robot.table.command_index["RelaxRear"]

    found = hypotheses(robot, program, driver.state, relax)

    assert [each.command for each in found] == ["", "RelaxRear"]


def test_a_command_that_would_have_been_refused_is_none(drive):
    driver = at_rest(drive(IDLE, states=BOTH_CLAMPED))
    robot, program = driver.robot, driver.engine.program
    clamp = robot.table.command_index["ClampRear"]

    assert len(hypotheses(robot, program, driver.state, clamp)) == 1
