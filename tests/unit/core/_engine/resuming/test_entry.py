"""Where a mission goes on, and what it does first: rules 2 to 5 on missions written here."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import pytest
from cut_off import GRIPPING, CutOff
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, REAR_CLAMPED, changed_newt, command

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.mission.program import Do, Enter, Wait
from pirate_sm.core._engine.resuming.hypotheses import hypotheses
from pirate_sm.core._engine.resuming.resumption import Entry, Refused, entry, resumed_program
from pirate_sm.core._engine.robot.robot_state import RESTORING, Mark
from pirate_sm.core._engine.sensing.known_signals import with_changes
from pirate_sm.core._model import events as ev

STEPS = """\
start: work
on_failure: unclear
phases:
  work:
    do: [DriveForward, ToggleLighting]
    wait:
      - {when: change(odometry) >= 1 m, go: done}
      - {after: 50 s, go: late}
    within: {time: 60 s, go: late}
  unclear: {do: [{command: Brake, unneeded: skip}], go: unsure}
ends:
  done: {succeed: There}
  late: {fail: Late}
  unsure: {fail: "{cause}"}
"""


def clamped(drive, body: str):
    driver = drive(body, states=BOTH_CLAMPED)
    driver.signals |= GRIPPING
    driver.run(0.4)
    return driver


def waiting(drive, body: str = STEPS):
    """The mission drives, its light is on, and it has waited for 10 s."""
    driver = clamped(drive, body)
    driver.until(lambda seen: seen.of(fx.WaitArmed))
    while driver.in_flight:
        driver.accept()
    turning = {f"theta_{n}": (1.5 if n in (1, 3, 5) else -1.5) for n in range(1, 7)}
    driver.run(driver.now + 10.0, **turning)
    assert not driver.ended
    return driver


def begun(driver):
    """The hold is accepted and the boards have been looked at."""
    driver.accept()
    driver.run(4.0)
    return driver


LOOSE = {"bend_torque_1": -0.3, "bend_torque_2": 0.3, "bend_torque_3": -0.3, "bend_torque_4": 0.3}
"""No part is seen to hold, and none is seen not to."""


class TestGoingOnInAWait:
    def test_nothing_is_sent_before_the_hold_is_accepted(self, drive):
        driver = CutOff(waiting(drive)).go_on()
        driver.run(5.0)

        assert [each.values for each in driver.of(fx.Setpoints)] == [driver.setpoints.values]
        assert not driver.statuses

    def test_the_hold_keeps_what_was_recorded_and_stops_the_wheels(self, drive):
        before = waiting(drive)
        recorded = before.state.robot.values
        driver = CutOff(before).go_on()

        wheels = set(driver.robot.safe_zero)
        for slot, (held, was) in enumerate(zip(driver.setpoints.values, recorded, strict=True)):
            assert held == (0.0 if slot in wheels else was)

    def test_the_wheels_are_driven_again_and_nothing_else_is_repeated(self, drive):
        driver = begun(CutOff(waiting(drive)).go_on())
        driver.until(lambda seen: seen.of(fx.WaitArmed))

        assert [name for name, status in driver.statuses if status == "sent"] == ["DriveForward"]
        assert driver.phases == ["work"]

    def test_a_wait_has_the_rest_of_its_time(self, drive):
        driver = begun(CutOff(waiting(drive)).go_on())
        driver.until(lambda seen: seen.of(fx.WaitArmed))
        driver.accept()
        turning = {f"theta_{n}": (0.65 if n in (1, 3, 5) else -0.65) for n in range(1, 7)}
        driver.run(driver.now + 30.0, every=0.4, **turning)
        assert not driver.fired

        driver.run(driver.now + 11.0, every=0.4, **turning)
        assert driver.fired == ["late"]

    def test_a_change_goes_on_from_where_it_counted(self, drive):
        before = waiting(drive)
        way_m = before.state.sensing.numbers[before.robot.odometry]
        assert way_m > 0.3
        driver = CutOff(before).go_on()

        odometry = driver.engine.signals(driver.state)["odometry"]
        assert odometry == pytest.approx(way_m, abs=1e-6)

    def test_a_change_needs_only_what_was_left_of_it(self, drive):
        driver = begun(CutOff(waiting(drive)).go_on())
        driver.until(lambda seen: seen.of(fx.WaitArmed))
        driver.accept()
        forward = {f"theta_{n}": (3.0 if n in (1, 3, 5) else -3.0) for n in range(1, 7)}
        before_m = driver.engine.signals(driver.state)["odometry"]
        assert 0.3 < before_m < 0.9

        driver.run(driver.now + (0.95 - before_m) / (3.0 * 0.024), **forward)
        assert not driver.fired
        driver.run(driver.now + 0.1 / (3.0 * 0.024), **forward)
        assert driver.fired == ["done"]

    def test_a_phase_that_counts_on_does_so_after_it_was_cut_off_before_its_wait(self, drive):
        legs = STEPS.replace("1 m, go: done}", "1 m, go: done}\n      - {after: 1 s, go: rest}")
        rest = "  rest:\n    do: [{wait: [{after: 5 s}]}]\n    counts_on: true\n"
        rest += "    wait: [{when: change(odometry) >= 1 m, go: done}]\n"
        rest += "    within: {time: 60 s, go: late}\n"
        before = waiting(drive, legs.replace("  unclear:", rest + "  unclear:"))
        before.until_waiting("rest")
        origin = before.state.mission.origin
        assert origin

        assert CutOff(before).go_on().state.mission.origin == origin

    def test_an_unknown_way_hides_the_position_but_not_later_changes(self, drive):
        driver = CutOff(waiting(drive), driven_s=0.4).go_on(
            **{f"theta_{n}": 0.0 for n in range(1, 7)}
        )

        assert isnan(driver.engine.signals(driver.state)["odometry"])
        begun(driver).until(lambda seen: seen.of(fx.WaitArmed))
        rolled = {f"theta_{n}": (1.5 if n in (1, 3, 5) else -1.5) for n in range(1, 7)}
        driver.run(driver.now + 1.0, **rolled)
        sensing = driver.state.sensing
        assert (
            with_changes(sensing, sensing.counted)[len(sensing.numbers) + driver.robot.odometry]
            == 0.0
        )


class TestAClampThatIsNotSeen:
    def test_wheels_are_not_driven_before_a_clamp_is_confirmed(self, drive):
        driver = begun(CutOff(waiting(drive)).go_on(**LOOSE))

        assert driver.statuses[0] == ("ClampFront", "sent")
        assert all(driver.setpoints.values[slot] == 0 for slot in driver.robot.safe_zero)

    def test_without_a_clamp_in_time_the_mission_fails_as_it_says(self, drive):
        driver = begun(CutOff(waiting(drive)).go_on(**LOOSE))
        while driver.in_flight:
            driver.accept()
        driver.run(50.0)

        assert ("ClampFront", "failed") in driver.statuses
        assert "unclear" in driver.phases
        assert {name for name, status in driver.statuses if status == "sent"} == {
            "ClampFront",
            "Brake",
        }


def test_a_command_under_way_is_given_again(drive):
    body = STEPS.replace("[DriveForward, ToggleLighting]", "[ClampRear]")
    driver = drive(body, states=FRONT_CLAMPED)
    driver.signals |= GRIPPING | {"bend_torque_4": 0.0}
    driver.run(0.4)
    assert driver.statuses == [("ClampRear", "sent")]
    driver.accept()

    again = begun(CutOff(driver).go_on())

    assert [name for name, status in again.statuses if status == "sent"] == ["ClampRear"]


QUESTION = """\
start: ask
phases:
  ask: {do: [{ask: "Is it dry?", choices: {"yes": continue, "no": fail}}], go: done}
ends: {done: {succeed: Dry}}
"""


def test_an_open_question_is_asked_again(drive):
    driver = clamped(drive, QUESTION)
    assert driver.of(fx.Ask)

    again = begun(CutOff(driver).go_on())

    assert [each.question for each in again.of(fx.Ask)] == ["Is it dry?"]


class TestAPhaseThatSaysWhereToGoOn:
    BODY = """\
start: first
phases:
  first: {do: [ToggleLighting], go: second}
  second: {resume: RESUME, do: [{ask: "Go on?"}], go: done}
ends: {done: {succeed: Done}}
"""

    def cut(self, drive, resume: str) -> CutOff:
        driver = clamped(drive, self.BODY.replace("RESUME", resume))
        driver.until(lambda seen: seen.of(fx.Ask))
        return CutOff(driver)

    def test_never_refuses(self, drive):
        assert "resume: never" in self.cut(drive, "never").why_not()

    def test_another_phase_is_begun(self, drive):
        driver = begun(self.cut(drive, "first").go_on())

        assert driver.phases[0] == "first"

    def test_here_goes_on_in_it(self, drive):
        assert begun(self.cut(drive, "here").go_on()).phases == ["second"]

    def test_the_operator_may_say_another(self, drive):
        driver = begun(self.cut(drive, "never").go_on(at="first"))

        assert driver.phases[0] == "first"

    def test_an_unknown_phase_is_refused(self, drive):
        assert self.cut(drive, "here").why_not(at="nowhere") == "the mission has no phase nowhere"


def test_regripping_goes_where_a_failure_leads(drive):
    assert begun(CutOff(waiting(drive)).go_on(at="failure")).phases[0] == "unclear"


def test_without_on_failure_there_is_nothing_to_go_to(drive):
    assert "no `on_failure`" in CutOff(clamped(drive, QUESTION)).why_not(at="failure")


def test_a_mission_at_its_end_does_not_go_on(drive):
    driver = clamped(drive, QUESTION)
    driver.give(ev.Answer("yes"))

    assert CutOff(driver).why_not() == "the mission had come to its end"


def test_a_paused_mission_goes_on_paused(drive):
    driver = waiting(drive)
    driver.give(ev.Pause())
    driver.accept()

    again = begun(CutOff(driver).go_on())

    assert again.state.mission.paused
    assert not again.statuses


def test_a_pause_that_was_pressed_just_before_the_crash_counts(drive):
    driver = waiting(drive)
    command(driver, "DriveBackward")
    driver.give(ev.Pause())
    assert driver.state.mission.pause_wanted
    assert not driver.state.mission.paused

    again = begun(CutOff(driver).go_on())

    assert again.state.mission.paused
    assert not again.statuses


def test_a_mission_does_not_go_on_if_the_operator_changed_the_clamps_in_its_pause(drive):
    driver = clamped(drive, QUESTION)
    driver.give(ev.Pause())
    driver.until(lambda seen: seen.state.mission.paused)
    assert begun(CutOff(driver).go_on()).state.mission.paused
    command(driver, "RelaxRear")
    driver.accept()
    assert driver.states["BendingState"] == "FrontClampedRearRelaxed"

    assert "the operator had changed the configuration" in CutOff(driver).why_not()


def test_the_first_array_stops_a_joint_that_a_position_loop_was_turning(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.run(0.4)
    command(driver, "BendInto")
    driver.accept()
    driver.run(1.0)
    while driver.in_flight:
        driver.accept()
    turning = driver.state.robot.seeking
    assert turning
    assert all(driver.state.robot.values[slot] != 0.0 for slot in turning)

    held = CutOff(driver).go_on().setpoints.values

    assert [held[slot] for slot in turning] == [0.0] * len(turning)


def test_a_crash_while_resuming_resumes(drive):
    once = begun(CutOff(waiting(drive)).go_on(**LOOSE))
    assert once.statuses == [("ClampFront", "sent")]

    twice = begun(CutOff(once).go_on(**GRIPPING))
    twice.until(lambda seen: seen.of(fx.WaitArmed))

    assert ("DriveForward", "done") in twice.statuses


def test_the_time_limit_goes_on_from_where_it_was(drive):
    again = begun(CutOff(waiting(drive, "time_limit: 20 s\n" + STEPS)).go_on())
    assert not again.ended

    again.run(14.0, every=0.4)
    again.accept()

    assert again.ended is not None
    assert "time limit of 20 s" in again.ended.message


HANDLED = """\
start: work
on_fault: [{fault: motor.hot, go: cooling}]
phases:
  work: {do: [{ask: "Go on?"}], go: done}
  cooling: {do: [{ask: "Cool?"}], go: done}
ends: {done: {succeed: Done}}
"""


def test_a_fault_that_is_being_handled_is_not_handled_again(drive):
    driver = clamped(drive, HANDLED)
    driver.give(ev.FaultReport("motor.hot", "hot"))
    driver.accept()
    assert driver.phases[-1] == "cooling"

    again = begun(CutOff(driver).go_on())
    again.give(ev.FaultReport("motor.hot", "hot"))

    assert again.phases == ["cooling"]
    assert again.faults == [("motor.hot", "stop")]


RESTING = """\
start: rest
phases: {rest: {wait: [{operator: x, go: done}], within: {time: 1 h, go: done}}}
ends: {done: {succeed: Done}}
"""
LET_GO = "  - rule: never_let_go\n    after: clamps > 0\n    never: clamps == 0\n"
AHEAD = {"Grip": "BothHeld", "Crawl": "Ahead"}


@pytest.mark.parametrize(
    ("rule", "restored"),
    [
        (LET_GO, {"HoldNose", "HoldTail", "GoAhead"}),
        ("  - {rule: r, never: command == GoAhead}\n" + LET_GO, {"HoldNose", "HoldTail"}),
        ("  - {rule: r, never: command == HoldTail}\n" + LET_GO, {"HoldNose", "GoAhead"}),
    ],
)
def test_a_command_that_would_break_a_rule_does_not_restore_anything(
    drive, tmp_path, rule, restored
):
    driver = drive(RESTING, changed_newt(tmp_path, (LET_GO, rule)), states=AHEAD)
    robot, program, last = driver.robot, driver.engine.program, driver.state
    body = hypotheses(robot, program, last)[0].body

    found = entry(robot, program, last, driver.now, body)

    assert isinstance(found, Entry)
    assert {robot.commands[each].name for each in found.restoring} == restored


def test_clamps_are_restored_before_wheels_and_only_what_was_confirmed(drive):
    driver = waiting(drive)
    robot, program, last = driver.robot, driver.engine.program, driver.state
    body = hypotheses(robot, program, last)[0].body

    def restored(last, at="here"):
        found = entry(robot, program, last, driver.now, body, at)
        return [robot.commands[each].name for each in found.restoring]

    assert restored(last) == ["ClampFront", "ClampRear", "DriveForward"]
    assert restored(last, "unclear") == ["ClampFront", "ClampRear"], "its phase drives them"
    front = Mark("part", 0, robot.table.command_index["ClampFront"])
    doubted = last._replace(robot=last.robot._replace(marks=frozenset({front})))
    assert restored(doubted) == ["ClampRear", "DriveForward"]


def test_an_angle_is_restored_too_where_wheels_are_not_driven_again(drive):
    states = BOTH_CLAMPED | {"RotationState": "AlignedStraight"}
    driver = drive(STEPS, states=states)
    driver.signals |= GRIPPING
    driver.run(0.4)
    robot, program, last = driver.robot, driver.engine.program, driver.state
    found = entry(robot, program, last, 0.4, hypotheses(robot, program, last)[0].body, "unclear")

    assert "AlignStraight" in {robot.commands[each].name for each in found.restoring}


def test_the_command_under_way_is_not_restored_besides(drive):
    driver = drive(STEPS.replace("[DriveForward,", "[ClampFront,"), states=REAR_CLAMPED)
    driver.until(lambda seen: seen.in_flight)
    robot, program, last = driver.robot, driver.engine.program, driver.state
    sent = hypotheses(robot, program, last)[1]
    assert sent.command == "ClampFront"

    found = entry(robot, program, last, driver.now, sent.body)

    assert "ClampFront" not in {robot.commands[each].name for each in found.restoring}
    assert "ClampRear" in {robot.commands[each].name for each in found.restoring}


def test_a_wait_that_was_not_armed_yet_has_its_whole_time(drive):
    driver = waiting(drive)
    robot, program, last = driver.robot, driver.engine.program, driver.state
    body = hypotheses(robot, program, last)[0].body
    pending = last._replace(mission=last.mission._replace(begun=False))

    assert entry(robot, program, last, driver.now, body).armed_s == pytest.approx(10.0, abs=0.5)
    assert entry(robot, program, pending, driver.now, body).armed_s == 0.0


REPEATED = """\
start: work
phases:
  work: {do: [{repeat: {times: 3, do: [{ask: "Again?", choices: {"on": continue}}]}}], go: done}
ends: {done: {succeed: Done}}
"""


def test_a_repeat_goes_on_in_its_turn(drive):
    driver = clamped(drive, REPEATED)
    driver.until(lambda seen: seen.of(fx.Ask))
    driver.give(ev.Answer("on"))
    program = driver.engine.program
    assert program.turn_of[driver.state.mission.pc] == "2 of 3"

    again = begun(CutOff(driver).go_on())

    resumed = again.engine.program
    assert resumed.turn_of[again.state.mission.pc] == "2 of 3"
    assert len(resumed.turn_of) == len(resumed.instructions)
    again.give(ev.Answer("on"))
    assert resumed.turn_of[again.state.mission.pc] == "3 of 3"
    again.give(ev.Answer("on"))
    again.until(lambda seen: seen.ended)


def test_a_command_that_was_restored_already_counts_as_done(drive):
    handled = "on_fault: [{fault: robot.stuck, go: again}]\n" + STEPS
    again = "  again: {do: [DriveForward], wait: [{after: 9 s, go: done}]}\n"
    driver = waiting(drive, handled.replace("phases:\n", f"phases:\n{again}"))
    driver.give(ev.FaultReport("robot.stuck", "it does not move"))
    driver.until_sent("DriveForward", times=2)

    resumed = begun(CutOff(driver).go_on())
    resumed.until(lambda seen: seen.of(fx.WaitArmed))

    assert resumed.phases == ["again"]
    assert [each for each in resumed.statuses if each[1] == "sent"] == [("DriveForward", "sent")]


class TestExactly:
    """What is returned for a mission that waits, and the program that begins there."""

    @pytest.fixture
    def driver(self, drive):
        return waiting(drive)

    @staticmethod
    def entry_of(driver, last=None, program=None, at: str = "here", control: int = 0):
        robot, last = driver.robot, last or driver.state
        body = hypotheses(robot, driver.engine.program, last)[0].body._replace(control=control)
        return entry(robot, program or driver.engine.program, last, driver.now, body, at)

    @pytest.mark.parametrize("ended", [True, False])
    def test_a_mission_that_has_ended_or_is_ending_does_not_go_on(self, driver, ended):
        over = {"ended": True} if ended else {"ending": fx.Ended("failed", "late", "")}
        last = driver.state._replace(mission=driver.state.mission._replace(**over))

        assert self.entry_of(driver, last) == Refused("the mission had come to its end")

    def test_only_a_wait_has_been_armed_for_a_time(self, driver):
        program, pc = driver.engine.program, driver.state.mission.pc
        command = next(n for n, it in enumerate(program.instructions) if isinstance(it, Do))
        mission = driver.state.mission._replace(pc=command)

        found = self.entry_of(driver, driver.state._replace(mission=mission))

        assert (found.pc, found.armed_s) == (command, 0.0)
        assert self.entry_of(driver).pc == pc
        assert self.entry_of(driver).armed_s > 0.0

    def test_another_phase_is_begun_under_the_control_in_force(self, driver):
        program, pc = driver.engine.program, driver.state.mission.pc
        work, unclear = program.phase_of[pc], program.enter("unclear")
        leading = tuple(
            it._replace(resume=unclear) if isinstance(it, Enter) and it.phase == work else it
            for it in program.instructions
        )
        plain = replace(program, instructions=leading)
        under_controls = replace(plain, entries={"unclear": ((0, 1), (1, 2))})

        assert self.entry_of(driver, program=plain, control=1).pc == unclear
        assert self.entry_of(driver, program=under_controls, control=0).pc == unclear
        assert self.entry_of(driver, program=under_controls, control=1).pc == 2

    def test_the_program_enters_the_phase_restores_and_goes_on_with_the_wait(self, driver):
        program, pc = driver.engine.program, driver.state.mission.pc
        first, failed = len(program.instructions), program.enter("unclear")

        resumed = resumed_program(program, Entry(pc, (4, 7), 10.0))

        assert resumed.start == first
        enter, *restoring, goal = resumed.instructions[first:]
        assert enter == Enter("work", first + 1, failed, "here")
        assert restoring == [
            Do(4, None, 0, True, first + 2, failed, RESTORING),
            Do(7, None, 0, True, first + 3, failed, RESTORING),
        ]
        assert isinstance(goal, Wait)
        assert goal.within_s == pytest.approx(program.instructions[pc].within_s - 10.0)
        assert goal.counts_on
        assert resumed.phase_of[first:] == ("work",) * 4
        assert resumed.handlers[first:] == (program.handlers[pc],) * 4

    def test_a_program_without_turns_goes_on_without_any(self, driver):
        plain = replace(driver.engine.program, turn_of=())

        assert resumed_program(plain, Entry(0)).turn_of == ("", "")

    def test_a_wait_that_was_not_armed_counts_from_its_own_beginning(self, driver):
        program, pc = driver.engine.program, driver.state.mission.pc

        goal = resumed_program(program, Entry(pc)).instructions[-1]

        assert goal == program.instructions[pc]
        assert not goal.counts_on

    def test_a_time_that_has_passed_leaves_none(self, driver):
        program, pc = driver.engine.program, driver.state.mission.pc

        goal = resumed_program(program, Entry(pc, armed_s=1000.0)).instructions[-1]

        assert goal.within_s == 0.0
        assert [each.after_s for each in goal.triggers] == [None, 0.0]
