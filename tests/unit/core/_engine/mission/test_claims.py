"""What a mission claims by a distance needs a bound that bears it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest
from driving import BOTH_CLAMPED, Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.mission.program import TriggerSpec
from pirate_sm.core._engine.mission.waiting import claim_of, counted, met_unknown
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.odometry import BASE_M
from pirate_sm.core._engine.state import Counted
from pirate_sm.core._model import events as ev

BODY = """\
on_fault: [{fault: distance.unknown, HANDLED}]
start: drive
phases:
  drive:
    do: [DriveForward]
    wait: [{when: WHEN, go: NEXT}]
    within: {time: 1 h, go: late}
  look: {wait: [{when: WORD, go: there}], within: {time: 1 h, go: late}}
  unsure: {do: [{command: Brake, unneeded: skip}], go: unknown}
ends:
  there: {succeed: There}
  late: {fail: Late}
  unknown: {fail: "{cause}"}
"""


def driven(
    drive,
    when: str = "change(odometry) >= 1 m",
    *,
    width_m: float = 0.0,
    before_m: float = 0.0,
    rolled_m: float = 1.0,
    late_m: float = 0.0,
    handled: str = "go: unsure",
    go: str = "there",
    word: str = "detector == past",
    said: str = "There",
) -> Driver:
    """A robot that drives a metre, while its distance becomes less certain by this.

    It had driven two, to 0.4 m, and was uncertain by `before_m` when its wait began, and by
    `late_m` for what its wheels had not reported yet.
    """
    body = (
        BODY.replace("succeed: There", f"succeed: '{said}'")
        .replace("WHEN", when)
        .replace("HANDLED", handled)
    )
    driver = drive(body.replace("NEXT", go).replace("WORD", word), states=BOTH_CLAMPED)
    widen(driver, before_m, 2.0, late_m)
    numbers = list(driver.state.sensing.numbers)
    numbers[driver.robot.odometry] = 0.4
    sensing = driver.state.sensing._replace(numbers=tuple(numbers))
    driver.state = driver.state._replace(sensing=sensing)
    driver.until_waiting("drive")
    turning = {f"theta_{n}": 4.0 if n % 2 else -4.0 for n in range(1, 7)}
    driver.run(driver.now + 5.0, **turning)
    assert not driver.fired
    widen(driver, before_m + width_m, 2.0 + rolled_m)
    while not driver.fired and not driver.ended and not driver.faults:
        driver.run(driver.now + 0.1, **turning)
    return driver


def widen(driver: Driver, width_m: float, rolled_m: float = 0.0, late_m: float = 0.0) -> None:
    sensing = driver.state.sensing
    memory = sensing.distance._replace(
        width_m=width_m, rolled_m=rolled_m, late_m=BASE_M + late_m, every_s=1e9
    )
    driver.state = driver.state._replace(sensing=sensing._replace(distance=memory))


def finish(driver: Driver) -> fx.Ended | None:
    for _ in range(20):
        if driver.in_flight:
            driver.accept()
        driver.run(driver.now + 0.1)
    return driver.ended


@pytest.mark.parametrize(("width_m", "known"), [(0.0, True), (0.22, True), (0.26, False)])
def test_belief_in_a_success_ends_where_its_distance_is_wrong_by_a_quarter(
    drive, width_m: float, known: bool
) -> None:
    driver = driven(drive, width_m=width_m)

    ended = finish(driver)

    assert ended is not None
    if known:
        assert (ended.outcome, driver.faults) == ("succeeded", [])
    else:
        assert driver.faults == [("distance.unknown", "unsure")]
        assert ended.outcome == "failed"
        assert "from there; this must be known within 250 mm" in ended.message
        assert f"but the robot may be {(width_m + BASE_M) * 1000:.0f} mm" in ended.message
        assert ended.message.startswith("distance.unknown: the wheels show 10")


def test_belief_in_a_success_ends_where_the_wheels_were_late_when_its_distance_began(drive) -> None:
    driver = driven(drive, width_m=0.22, late_m=0.04)

    assert finish(driver)
    assert driver.faults == [("distance.unknown", "unsure")]


def test_a_success_names_the_distance_that_was_measured(drive) -> None:
    """Its trigger asks for 1000 mm, and what the wheels show when it fires is a little more."""
    driver = driven(drive, "change(odometry) >= 1 m", width_m=0.02, said="{driven} farther on")

    ended = finish(driver)

    assert ended is not None
    assert ended.message == "1001 ± 25 mm farther on"


def test_a_text_names_no_distance_that_is_not_known(drive) -> None:
    """A success by it would not be believed either."""
    driver = driven(drive, width_m=3.0, handled="then: continue", said="At {driven}")

    ended = finish(driver)

    assert ended is not None
    assert ended.message == "At an unknown distance"


def test_what_was_uncertain_before_a_change_began_is_not_counted(drive) -> None:
    driver = driven(drive, before_m=0.5)

    ended = finish(driver)

    assert ended is not None
    assert ended.outcome == "succeeded"


def test_a_position_counts_from_the_start_of_the_run(drive) -> None:
    driver = driven(drive, "odometry >= 1.4 m", before_m=0.8)

    ended = finish(driver)

    assert ended is not None
    assert ended.outcome == "failed"
    assert driver.faults == [("distance.unknown", "unsure")]


@pytest.mark.parametrize(("within", "known"), [("30 mm", True), ("20 mm", False)])
def test_a_trigger_may_ask_for_a_bound_of_its_own(drive, within: str, known: bool) -> None:
    driver = driven(
        drive, f"change(odometry) >= 1 m known within {within}", width_m=0.02, go="look"
    )

    assert driver.fired == (["look"] if known else [])
    assert (driver.faults == []) == known
    if not known:
        assert "must be known within 20 mm" in driver.of(fx.Fault)[0].message


def test_a_short_way_need_not_be_known_within_less_than_20_mm(drive) -> None:
    driver = driven(drive, width_m=0.0149, rolled_m=0.01)

    ended = finish(driver)

    assert ended is not None
    assert ended.outcome == "succeeded"


def test_a_word_says_anew_where_the_robot_is(drive) -> None:
    driver = driven(drive, width_m=5.0, go="look")
    driver.give(ev.DetectorWord("past", 60.0))

    ended = finish(driver)

    assert ended is not None
    assert (ended.outcome, driver.faults) == ("succeeded", [])


def test_a_wait_for_something_else_leaves_the_claim(drive) -> None:
    driver = driven(drive, width_m=5.0, go="look", word="bend_torque_1 > 1 mNm")
    driver.signals["bend_torque_1"] = 0.7

    ended = finish(driver)

    assert ended is not None
    assert ended.outcome == "failed"
    assert driver.faults == [("distance.unknown", "unsure")]


def test_a_mission_may_continue_in_spite_of_it(drive) -> None:
    asked = "change(odometry) >= 1 m known within 20 mm"
    driver = driven(drive, asked, width_m=5.0, handled="then: continue", go="look")

    assert driver.fired == ["look"]
    assert driver.faults == [("distance.unknown", "continue")]


def test_a_mission_may_go_elsewhere_because_of_it(drive) -> None:
    driver = driven(drive, "change(odometry) >= 1 m known within 20 mm", width_m=5.0)

    ended = finish(driver)

    assert driver.faults == [("distance.unknown", "unsure")]
    assert ended is not None
    assert ended.outcome == "failed"
    assert ended.message.startswith("distance.unknown: the wheels show 10")


def test_an_operator_who_skips_a_wait_claims_nothing(drive) -> None:
    body = BODY.replace("WHEN", "change(odometry) >= 1 m known within 20 mm")
    body = body.replace("HANDLED", "go: unsure").replace("NEXT", "there")
    driver = drive(body.replace("WORD", "detector == past"), states=BOTH_CLAMPED)
    driver.until_waiting("drive")
    widen(driver, 5.0)

    driver.give(ev.Skip(""))
    ended = finish(driver)

    assert ended is not None
    assert (ended.outcome, driver.faults) == ("succeeded", [])


def test_on_paper_nothing_is_uncertain(drive) -> None:
    driver = driven(drive, width_m=5.0, go="look", word="bend_torque_1 > 1 mNm")
    distance = driver.state.sensing.distance._replace(every_s=0.0)
    sensing = driver.state.sensing._replace(distance=distance)
    driver.state = driver.state._replace(sensing=sensing)
    driver.signals["bend_torque_1"] = 0.7

    ended = finish(driver)

    assert ended is not None
    assert ended.outcome == "succeeded"


def test_a_recording_of_before_claims_as_it_did(drive) -> None:
    driver = drive(
        BODY.replace("WHEN", "odometry >= 1 m")
        .replace("HANDLED", "go: unsure")
        .replace("NEXT", "there")
        .replace("WORD", "detector == past"),
        states=BOTH_CLAMPED,
    )
    engine = Engine(driver.robot, driver.engine.program, nominal=False, alphabet=9)

    state, _ = engine.start(0.0, body=driver.state.robot)

    assert state.sensing.distance.every_s == 0.0


def moment(driver: Driver, robot: RobotSpec | None = None) -> Moment:
    return Moment(robot or driver.robot, driver.engine.program, False, driver.now)


class TestExactly:
    """A claim from 0.4 m on, where the robot was uncertain by 10 mm and had driven 1 m."""

    @pytest.fixture
    def driver(self, drive) -> Driver:
        return drive(
            BODY.replace("HANDLED", "go: unsure")
            .replace("NEXT", "there")
            .replace("WHEN", "odometry >= 1 m")
            .replace("WORD", "detector == past"),
            states=BOTH_CLAMPED,
        )

    @staticmethod
    def met(driver: Driver, width_m: float, rolled_m: float, every_s: float = 0.1):
        state, at = driver.state, driver.robot.odometry
        distance = state.sensing.distance._replace(
            every_s=every_s, width_m=width_m, rolled_m=rolled_m
        )
        numbers = list(state.sensing.numbers)
        numbers[at] = 1.4
        sensing = state.sensing._replace(distance=distance, numbers=tuple(numbers))
        mission = state.mission._replace(claim=Counted(0.4, 0.01, 1.0))
        return met_unknown(moment(driver), state._replace(sensing=sensing, mission=mission))

    @pytest.mark.parametrize(
        ("driven_m", "limit_m"), [(4.0, 1.0), (0.4, 0.1), (0.04, 0.02), (0.0, 0.02)]
    )
    def test_the_bound_may_be_a_quarter_of_the_way_and_20_mm_in_any_case(
        self, driver, driven_m, limit_m
    ):
        width_m = 0.01 + limit_m - BASE_M

        assert self.met(driver, width_m - 1e-6, 1.0 + driven_m) is None
        assert self.met(driver, width_m + 1e-6, 1.0 + driven_m) is not None

    def test_where_no_distance_is_judged_none_is_too_wide(self, driver):
        assert self.met(driver, 9.0, 1.0, every_s=0.0) is None
        assert self.met(driver, 9.0, 1.0, every_s=1.0) is not None

    @pytest.mark.parametrize("odometry", [0, 1])
    def test_an_odometry_of_any_place_counts(self, driver, odometry):
        now = moment(driver, replace(driver.robot, odometry=odometry))
        names = driver.robot.vocabulary.numbers
        numbers = [0.0] * len(names)
        numbers[odometry] = 0.7
        state = driver.state._replace(sensing=driver.state.sensing._replace(numbers=tuple(numbers)))

        assert counted(now, state).odometry_m == 0.7
        trigger = TriggerSpec(
            "done", "", 0, "", SimpleNamespace(names=frozenset({names[odometry]}))
        )
        assert claim_of(now, state, trigger) == Counted()

    def test_without_odometry_nothing_is_counted(self, driver):
        now = moment(driver, replace(driver.robot, odometry=-1))

        assert counted(now, driver.state).odometry_m == 0.0
