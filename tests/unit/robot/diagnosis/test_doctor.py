"""What is found out about an emulated bay with each of its troubles, in virtual time."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from math import degrees, nan
from statistics import median

import pytest
from representative import thorough_but

from pirate_sm.cli.commands.doctor import _look_around
from pirate_sm.cli.options.devices import DoctorOptions
from pirate_sm.core.errors import BackendError
from pirate_sm.robot.calibration_files import with_zeros
from pirate_sm.robot.diagnosis.facts import ExpectedRobot, Facts
from pirate_sm.robot.diagnosis.judgement import judged
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.robot.diagnosis.moving import Moving

from .conftest import BayPort, Connect, bay_of

Examine = Callable[..., Facts]


def messages(facts: Facts, level: str) -> list[str]:
    return [finding.message for finding in facts.findings if finding.level == level]


@pytest.fixture
def examine(connect: Connect, subject: ExpectedRobot) -> Examine:
    def examined(*, move: bool = False, **switches: object) -> Facts:
        with connect(**switches) as listening:
            listening.listen(5.0)
            facts = listening.facts()
            if move:
                moved = Moving(listening, lambda text: None).run()
                facts = replace(facts, move=moved)
        return judged(facts, subject)

    return examined


def test_a_healthy_bay_is_go_and_nothing_was_sent_to_its_motors(
    connect: Connect, subject: ExpectedRobot
) -> None:
    with connect() as listening:
        listening.listen(5.0)
        facts = judged(listening.facts(), subject)
    bay = bay_of(listening)

    assert facts.go
    assert messages(facts, "no-go") == messages(facts, "suspicious") == []
    assert bay.last_array is None
    assert not bay.configured  # it was told to be quiet


def test_topics_are_shown_with_both_md5s_and_the_rate_of_their_messages(examine: Examine) -> None:
    facts = examine()

    topics = {topic.name: topic for topic in facts.topics}
    assert set(topics) == {"setpoint_array", "setpoint_echo", "state"}
    assert all(topic.agrees and topic.md5 == topic.our_md5 for topic in topics.values())
    assert topics["state"].id == 125
    assert 55 < topics["state"].per_s < 62.6


def test_every_fitted_board_and_sensor_is_shown_raw_and_in_si(examine: Examine) -> None:
    facts = examine()

    assert [board.id for board in facts.boards] == [22, 23, 24, 25, 26, 27]
    for board in facts.boards:
        assert 0.9 * board.expected_per_s < board.per_s <= 1.1 * board.expected_per_s
    down = {c.signal: c for board in facts.boards for c in board.channels}["acc_z"]
    assert down.raw == pytest.approx(16384, rel=0.05)
    assert down.value == pytest.approx(9.81, rel=0.05)
    assert down.shown.endswith("m/s^2")


def test_a_question_takes_about_a_cycle_to_be_answered(examine: Examine) -> None:
    facts = examine()

    assert len(facts.link.asked_ms) >= 3
    assert 5 < median(facts.link.asked_ms) < 40


def test_sensors_that_were_not_started_are_no_go_with_what_to_do_at_the_panel(
    examine: Examine,
) -> None:
    facts = examine(sensors_started=False)

    assert not facts.go
    assert messages(facts, "no-go") == [
        "no board reports: push [Set] on the MIDI panel, the blue LEDs of the boards should then "
        "blink"
    ]


def test_motors_that_ignore_setpoints_are_no_go_with_what_to_do_at_the_panel(
    examine: Examine,
) -> None:
    facts = examine(move=True, motors_started=False)

    assert not facts.go
    assert messages(facts, "no-go") == [
        "setpoints are echoed but no wheel turns: push [Play] on the MIDI panel, the red LEDs of "
        "the boards should then blink"
    ]


def test_each_wheel_that_is_asked_to_turns_and_stands_still_again(
    connect: Connect, subject: ExpectedRobot
) -> None:
    with connect() as listening:
        listening.listen(2.0)
        move = Moving(listening, lambda text: None).run()
        duties = bay_of(listening).duties

    assert [wheel.turned for wheel in move.wheels] == [True] * 6
    assert move.accepted == move.sent
    assert not any(duties)


def test_a_robot_that_holds_on_is_not_sent_zeros(connect: Connect, subject: ExpectedRobot) -> None:
    with connect() as listening:
        listening.listen(2.0)
        clamp = {"bend_1": -1.0, "bend_2": 1.0}
        array = tuple(clamp.get(slot.name, 0.0) for slot in subject.profile.slots)
        listening.exchange.submit(1, array, listening.port.now())
        listening.turn(listening.port.now() + 4.0)
        duties = tuple(bay_of(listening).duties)
        assert any(duties)

        facts = _look_around(listening, subject, DoctorOptions(move=True, json=True))

        assert tuple(bay_of(listening).duties) == duties
    assert facts.move is None
    assert not facts.go
    assert facts.findings[0].message.startswith("nothing was sent: bend_1, bend_2")


def test_no_wheel_turns_on_a_robot_that_its_worm_gears_hold_without_any_current(
    connect: Connect, subject: ExpectedRobot
) -> None:
    with connect() as listening:
        listening.listen(2.0)
        clamp = {"bend_1": -0.7, "bend_2": 0.7}
        array = tuple(clamp.get(slot.name, 0.0) for slot in subject.profile.slots)
        for number, values in enumerate((array, (0.0,) * len(array)), 1):  # as a reset leaves it
            listening.exchange.submit(number, values, listening.port.now())
            listening.turn(listening.port.now() + 12.0)
        arrays = len([each for each in bay_of(listening).records if each.event == "applied"])
        facts = _look_around(listening, subject, DoctorOptions(move=True, json=True))
        applied = [each for each in bay_of(listening).records if each.event == "applied"]

    assert not any(any(each.counts) for each in applied[arrays:])
    assert facts.findings[0].message.startswith("nothing was sent: bend_1, bend_2")
    assert facts.move is None


def test_a_joint_whose_load_is_not_shown_may_bear_one(
    connect: Connect, subject: ExpectedRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    with connect() as listening:
        listening.listen(2.0)
        moving = Moving(listening, lambda text: None)
        assert moving.bearing == ()

        monkeypatch.setattr(listening.records, "last", lambda board, place: nan)
        assert "bend_1" in moving.bearing


@pytest.mark.parametrize(
    "line",
    thorough_but([{"delay_s": 0.1}], [{}, {"delay_s": 0.1}, {"jitter_s": 0.05}]),
    ids=str,
)
def test_the_robot_has_seen_every_array_that_is_counted_as_written_or_repeated(
    connect: Connect, line: dict[str, float]
) -> None:
    with connect(**line) as listening:
        listening.listen(2.0)
        move = Moving(listening, lambda text: None).run()
        counts = listening.exchange.counts
        records = bay_of(listening).records
        received = sum(record.event == "received" for record in records)  # the port is still open

    assert counts.written - received in {0, 1}, "one refresh may be on its way"
    assert counts.written == move.sent + counts.repeats + counts.refreshes


def test_a_dead_wheel_is_suspicious_and_the_red_led_is_explained(examine: Examine) -> None:
    facts = examine(move=True, defects=("wheels_3_4_dead",))

    assert facts.go
    told = messages(facts, "suspicious")
    assert [line.split()[0] for line in told] == ["wheel_3", "wheel_4"]
    assert all("red LED" in line for line in told)


def test_whoever_stops_the_test_leaves_every_wheel_at_rest(connect: Connect) -> None:
    class Enough(Exception):  # noqa: N818
        pass

    def stop_once_it_turns() -> None:
        nonlocal stopped
        if not stopped and any(bay_of(listening).duties):
            stopped = True
            raise Enough

    stopped = False
    listening = connect(stop_once_it_turns)

    def try_wheels() -> None:
        with listening:
            listening.listen(1.0)
            Moving(listening, lambda text: None).run()

    with pytest.raises(Enough):
        try_wheels()

    bay = bay_of(listening)
    bay.advance(listening.port.now() + 0.2)
    assert not any(bay.duties)


def test_another_definition_is_no_go_and_is_not_asked_about_for_ever(
    connect: Connect, subject: ExpectedRobot
) -> None:
    with connect(wrong_md5=("state",)) as listening:
        before = len(bay_of(listening).records)
        listening.listen(5.0)
        facts = judged(listening.facts(), subject)

    (told,) = messages(facts, "no-go")
    assert "the firmware's pirate_msgs/State is another one than ours" in told
    assert facts.link.time_requests <= 3
    assert len(bay_of(listening).records) - before < 5


def test_the_firmwares_reset_is_seen(examine: Examine) -> None:
    facts = examine(reset_at_s=(4.0,))

    assert not facts.go
    assert any("it was reset" in line for line in messages(facts, "no-go"))


@pytest.mark.parametrize(
    ("switches", "told"),
    [
        ({"defects": ("gamma_2_sticks",)}, "gamma_2 has shown exactly the same"),
        ({"defects": ("imu_stale",)}, "acc_x has shown exactly the same"),
        ({"defects": ("gamma_3_spikes",)}, "gamma_3 has spiked"),
        ({"loss_out": 0.2}, "of the expected messages arrive"),
        ({"corruption": 0.01}, "bytes belonged to no whole frame"),
    ],
)
def test_what_is_strange_is_told_and_stops_nobody(
    examine: Examine, switches: dict[str, object], told: str
) -> None:
    facts = examine(**switches)

    assert facts.go
    assert any(told in line for line in messages(facts, "suspicious"))


def test_a_board_that_says_nothing_is_no_go_by_number_and_name(
    examine: Examine, subject: ExpectedRobot
) -> None:
    facts = examine()
    boards = tuple(
        replace(board, frames=0, per_s=0.0) if board.id == 26 else board for board in facts.boards
    )

    again = judged(replace(facts, boards=boards), subject)

    assert not again.go
    assert "no values come from board 26 (bend_3)" in messages(again, "no-go")[0]


def test_a_joint_at_its_end_stop_and_one_beyond_it_are_reported(
    examine: Examine, subject: ExpectedRobot
) -> None:
    facts = examine()
    first, *others = facts.boards
    angle, *rest = first.channels
    moved = replace(angle, value=2.08, raw=1356.0)

    again = judged(
        replace(facts, boards=(replace(first, channels=(moved, *rest)), *others)), subject
    )

    assert "gamma_1 is at its end stop (120 deg either way)" in messages(again, "suspicious")


def test_an_accelerometer_that_does_not_feel_gravity_is_reported(
    examine: Examine, subject: ExpectedRobot
) -> None:
    facts = examine()
    boards = tuple(
        replace(
            board,
            channels=tuple(
                replace(c, value=1.0) if c.signal == "acc_z" else c for c in board.channels
            ),
        )
        for board in facts.boards
    )

    again = judged(replace(facts, boards=boards), subject)

    assert any("gravity is 9.81" in line for line in messages(again, "suspicious"))


def test_joint_zeros_are_subtracted_from_what_is_shown(
    connect: Connect, subject: ExpectedRobot
) -> None:
    zeros = {"gamma_1": 0.1}
    calibrated = subject._replace(robot=with_zeros(subject.robot, zeros))
    listening = connect()
    listening.subject = calibrated

    with listening:
        listening.listen(1.0)
        shown = listening.facts().boards[0].channels[0]

    assert shown.value is not None
    assert degrees(shown.value) == pytest.approx(-degrees(0.1), abs=0.3)
    assert abs(shown.raw or 0.0) < 4


def test_the_facts_are_plain_json(examine: Examine) -> None:
    data = json.loads(json.dumps(examine(sensors_started=False).as_data(), allow_nan=False))

    assert data["go"] is False
    assert data["findings"][0]["level"] == "no-go"
    assert data["boards"][0]["channels"][0]["raw"] is None
    assert data["words"] == [{"level": 1, "text": "bay ready"}]


# --- no robot at all ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (b"", "nothing answers on virtual at 57600 baud"),
        (b"OK\r\n", "does not speak rosserial"),
        (b"\x80\x9f\xff", "bytes that make no sense at 57600 baud"),
    ],
)
def test_a_port_that_speaks_something_else_says_so_and_is_free_again(
    subject: ExpectedRobot, answer: bytes, told: str
) -> None:
    port = BayPort(None, answer)

    with pytest.raises(BackendError, match=told), Listening(subject, port, 57600):
        raise AssertionError("it connected")

    assert not port.is_open


def test_a_port_that_cannot_be_opened_says_why(subject: ExpectedRobot) -> None:
    port = BayPort(None)
    port.refuses = "it is in use"

    with pytest.raises(BackendError, match="it is in use"), Listening(subject, port, 57600):
        raise AssertionError("it connected")


@pytest.mark.parametrize(("late_s", "findings"), [(0.05, 0), (0.2, 1)])
def test_belief_a_computer_that_stands_still_is_found_before_it_stops_a_robot(
    connect: Connect, subject: ExpectedRobot, late_s: float, findings: int
) -> None:
    with connect() as listening:
        port, read = listening.port, listening.port.read

        def wakes_late(until_s: float) -> bytes:
            data = read(until_s)
            if 4.0 < port.now() < 4.2:
                port.wait(until_s + late_s)
            return data

        port.read = wakes_late  # type: ignore[method-assign]
        listening.listen(5.0)
        facts = judged(listening.facts(), subject)

    assert facts.link.stood_still_s == pytest.approx(late_s, abs=0.01)
    shown = [each for each in messages(facts, "suspicious") if "stood still for 0.20 s" in each]
    assert len(shown) == findings
    assert all("heartbeat_within" in each and "nice" in each for each in shown)
