"""The exchange by itself: bytes and times go in, no port is behind it."""

from __future__ import annotations

import pytest

from pirate_sm.core.events import Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.robot.backends.serial.link.exchange import Exchange
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import LOG, Decoder, LogLine, encode, log_payload

from ..device import NUMBERS, Device

CLAMPING = (0.0,) * 4 + (-0.7, 1.0, 0.7, -1.0) + (0.0,) * 10
OTHER = (0.0,) * 4 + (-0.6, 0.0, 0.6, 0.0) + (0.0,) * 10
TURN_S = 0.01
SILENCE_S = 2.0
"""Longer than eight waits for an echo, after which an array's fate would be unknown."""


class Talk:
    """An exchange and what a device says to it, one turn each 10 ms.

    Attributes:
        arrays: Payloads of the arrays that were written.
        able: Whether there is a port.
        speaking: Whether the device reports; ``echoing``: whether it echoes.
    """

    def __init__(self, plan: LinkPlan) -> None:
        self.device = Device(plan)
        self.now = 0.0
        self.exchange = Exchange(plan, self.now, 0.0, 57600)
        self.arrays: list[bytes] = []
        self.events: list[Event] = []
        self.results: list[SubmitResult] = []
        self.faults: list[str] = []
        self.able = self.speaking = self.echoing = True

    def start(self, watched: bool = True) -> None:
        """Topics are known and every board has reported."""
        self.now = 2.5
        for _ in range(2):
            for data in self.device.introduce():
                self.exchange.receive(data, self.now)
        assert self.exchange.conversation.known
        if watched:
            self.exchange.watch()
        self.run(0.5)

    def run(self, seconds: float) -> None:
        end_s = self.now + seconds
        while self.now < end_s:
            self.now += TURN_S
            if self.speaking:
                self.exchange.receive(encode(NUMBERS["state"], self.device.state()), self.now)
            while data := self.exchange.write(self.now, self.able):
                self.answer(data)
            events = self.exchange.take()
            self.events += events
            self.results += [event for event in events if isinstance(event, SubmitResult)]
            self.faults += [event.message for event in events if isinstance(event, FaultReport)]

    def answer(self, data: bytes) -> None:
        [(topic, payload)] = Decoder().feed(data)
        if topic != NUMBERS["setpoints"]:
            return
        self.arrays.append(payload)
        if self.echoing:
            self.exchange.receive(encode(NUMBERS["echo"], payload), self.now)

    def submit(self, number: int, values: tuple[float, ...]) -> None:
        self.exchange.submit(number, values, self.now)

    def interrupt(self) -> None:
        """The controller falls silent, and goes on by itself after longer than a moment."""
        self.speaking = self.echoing = False
        self.run(SILENCE_S)
        assert self.exchange.outage is not None
        self.speaking = True


@pytest.fixture
def talk(plan: LinkPlan) -> Talk:
    talk = Talk(plan)
    talk.start()
    return talk


def test_an_array_does_not_expire_while_the_controller_is_away(talk: Talk) -> None:
    talk.echoing = False
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.interrupt()

    assert talk.results == [], "its fate is open until the controller is back"


def test_an_array_does_not_expire_while_whoever_was_told_of_an_outage_decides(talk: Talk) -> None:
    talk.echoing = False
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.interrupt()
    talk.echoing = True
    talk.run(0.5)
    assert talk.exchange.aside

    assert talk.results == []
    talk.exchange.resume(talk.now)
    talk.run(0.5)
    assert talk.results == [SubmitResult(1, "accepted")]


def test_it_is_not_settled_while_something_newer_than_the_safe_array_waits(talk: Talk) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.5)
    talk.interrupt()
    talk.echoing = True
    talk.run(0.5)
    assert talk.exchange.aside
    assert talk.exchange.settled, "the safe array is in force"

    talk.submit(2, OTHER)

    assert not talk.exchange.settled
    talk.exchange.resume(talk.now)
    talk.run(0.5)
    assert talk.exchange.settled


def test_it_is_not_settled_while_an_outage_lasts(talk: Talk) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.5)
    assert talk.exchange.settled
    talk.interrupt()

    assert not talk.exchange.settled


def test_nothing_is_written_or_counted_as_written_without_a_port(talk: Talk) -> None:
    talk.able = False
    written = talk.exchange.counts.written
    talk.submit(1, CLAMPING)
    talk.run(0.1)

    assert talk.arrays == []
    assert talk.exchange.counts.written == written
    talk.able = True
    talk.run(0.1)
    assert len(talk.arrays) == 1
    assert talk.results == [SubmitResult(1, "accepted")]


def test_an_array_is_accepted_in_the_moment_in_which_its_echo_is_heard(talk: Talk) -> None:
    talk.echoing = False
    talk.submit(1, CLAMPING)
    talk.run(0.02)
    talk.exchange.receive(encode(NUMBERS["echo"], talk.arrays[-1]), talk.now)

    assert talk.exchange.take() == [SubmitResult(1, "accepted")]


def test_a_silence_ends_with_the_first_word_and_not_when_every_topic_is_known(talk: Talk) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.5)
    talk.speaking = False
    talk.run(SILENCE_S)
    first, *others = talk.device.introduce()
    talk.exchange.receive(first, talk.now)
    talk.run(0.3)
    for data in others:
        talk.exchange.receive(data, talk.now)
    talk.speaking = True
    talk.run(0.5)

    [fault] = talk.faults
    assert f"said nothing for {SILENCE_S:.1f} s" in fault


def test_a_controller_that_was_given_up_is_sent_copies_of_an_array_while_it_is_asked(
    talk: Talk,
) -> None:
    talk.speaking = talk.echoing = False
    talk.run(40.0)
    [fault] = talk.faults
    assert "however often it was asked" in fault
    assert talk.exchange.conversation.asking

    talk.submit(1, CLAMPING)
    talk.run(1.0)

    assert len(talk.arrays) > 3


def test_the_array_in_force_is_repeated_as_the_profile_asks(talk: Talk, plan: LinkPlan) -> None:
    every_s = plan.serial.refresh_every
    assert every_s is not None
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    assert len(talk.arrays) == 1

    talk.run(10 * every_s)

    assert 8 <= len(talk.arrays) - 1 <= 10


@pytest.mark.parametrize(("stop_after_s", "hurried"), [(0.3, True), (None, False)])
def test_arrays_follow_sooner_where_a_switch_would_stop_the_robot_on_a_line_that_loses_much(
    plan: LinkPlan, stop_after_s: float | None, hurried: bool
) -> None:
    serial = plan.serial.model_copy(update={"stop_after": stop_after_s})
    talk = Talk(plan._replace(serial=serial))
    talk.start()
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    for _ in range(5):
        talk.exchange.link.quality.lose(1.0)
    written = len(talk.arrays)

    talk.run(0.5)

    assert plan.serial.refresh_every is not None
    assert (len(talk.arrays) - written > 0.5 / plan.serial.refresh_every) == hurried


@pytest.mark.parametrize("watched", [True, False])
def test_a_port_that_goes_and_comes_back_says_the_first_reason(
    plan: LinkPlan, watched: bool
) -> None:
    talk = Talk(plan)
    talk.start(watched)
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.able = talk.speaking = False
    talk.exchange.lost("the cable is out", talk.now)
    talk.exchange.lost("it is still out", talk.now)
    talk.run(1.0)
    talk.able = talk.speaking = True
    talk.exchange.connected(talk.now)
    for _ in range(2):
        for data in talk.device.introduce():
            talk.exchange.receive(data, talk.now)
    talk.run(0.5)

    assert len(talk.faults) == watched
    assert all("(the cable is out) and is back" in fault for fault in talk.faults)


def test_a_port_that_goes_again_makes_the_safe_array_due_again(talk: Talk) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.interrupt()
    talk.run(0.05)
    outage = talk.exchange.outage
    assert outage is not None
    assert outage.back

    talk.exchange.lost("the cable is out", talk.now)

    assert not outage.back
    assert outage.gone == "the cable is out"


def test_whoever_sleeps_until_something_is_due_writes_the_safe_array_ten_times_a_second(
    talk: Talk,
) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.interrupt()
    talk.run(0.05)
    assert talk.exchange.outage is not None
    written_s = talk.exchange.outage.wrote_s

    assert talk.exchange.due_s(talk.now) == pytest.approx(written_s + 0.1)
    assert talk.exchange.due_s(written_s + 0.1) <= written_s + 0.1


def test_an_array_is_given_up_where_the_robot_never_says_its_topics(plan: LinkPlan) -> None:
    talk = Talk(plan)
    talk.speaking = False
    talk.submit(1, CLAMPING)

    talk.run(20.0)

    assert talk.arrays == []
    assert [result.setpoint_id for result in talk.results] == [1]
    assert talk.results[0].status != "accepted"


def test_a_slot_that_a_loop_drives_is_not_held_while_nothing_is_heard(
    talk: Talk, plan: LinkPlan
) -> None:
    talk.exchange.hold(CLAMPING, seeking=[5])
    talk.submit(1, CLAMPING)
    talk.run(0.1)

    [payload] = talk.arrays
    held = {at for at in range(len(plan.slots)) if at not in plan.safe_zero} - {5}
    assert plan.messages.setpoints.unpack(payload).hold == sum(1 << at for at in held)


@pytest.mark.parametrize("silent", [False, True])
def test_whoever_sleeps_until_something_is_due_waits_until_the_line_is_free(
    talk: Talk, silent: bool
) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    if silent:
        talk.interrupt()
        talk.run(0.15)
    else:
        talk.submit(2, OTHER)
    talk.exchange.throttle.wrote(1000, talk.now)
    now = talk.now + 0.11

    assert talk.exchange.outage is not None or not silent
    assert now < talk.exchange.due_s(now) <= talk.exchange.throttle.free_s(60, now)


def test_what_the_boards_reported_since_its_return_follows_the_fault(
    talk: Talk, plan: LinkPlan
) -> None:
    talk.submit(1, CLAMPING)
    talk.run(0.1)
    talk.interrupt()
    talk.echoing = True
    talk.events.clear()

    talk.run(1.0)

    fault, *after = talk.events
    assert isinstance(fault, FaultReport)
    frames = [each.board for each in after if isinstance(each, SensorFrame)]
    assert set(frames[: len(plan.channels)]) == set(plan.channels)


@pytest.mark.parametrize("reported", [True, False])
def test_a_controller_that_has_not_reported_since_it_began_is_not_reset(
    plan: LinkPlan, reported: bool
) -> None:
    talk = Talk(plan)
    talk.speaking = reported
    talk.start(watched=False)
    talk.speaking = False
    for _ in range(2):
        talk.run(SILENCE_S)
        for _ in range(2):
            for data in talk.device.introduce():
                talk.exchange.receive(data, talk.now)
    talk.run(0.1)

    assert len(talk.faults) == reported, "once only: it has not reported since its reset either"
    assert all("it was reset or hung" in fault for fault in talk.faults)


# --- a firmware that names its tables -------------------------------------------------------------

OURS, THEIRS = "robot ours, tables 0badcafe", "robot theirs, tables 12345678"


def told(plan: LinkPlan, *lines: str, running: bool = False) -> Talk:
    """A controller that has said these lines, at the start or in a mission."""
    talk = Talk(plan._replace(tables=OURS))
    if running:
        talk.start()
    for line in lines:
        talk.exchange.receive(encode(LOG, log_payload(LogLine(1, line))), talk.now)
    return talk


@pytest.mark.parametrize(
    "lines",
    [
        (f"firmware 1 of {OURS}",),
        (f"firmware 1 of {OURS}", f"firmware 1 of {THEIRS}"),  # damage that its sum misses
        ("no answer from board 25", "firmware 7 of our own"),
        (),
    ],
)
def test_a_firmware_that_names_our_tables_or_none_is_used(
    plan: LinkPlan, lines: tuple[str, ...]
) -> None:
    assert not told(plan, *lines).exchange.refused


def test_a_firmware_that_names_the_tables_of_another_robot_is_refused_once(plan: LinkPlan) -> None:
    talk = told(plan, *[f"firmware 1 of {THEIRS}"] * 3)

    (refused,) = talk.exchange.refused
    assert refused.startswith(f"the firmware is that of {THEIRS}, the profile is that of {OURS}")


def test_a_plan_that_knows_no_tables_compares_none(plan: LinkPlan) -> None:
    talk = Talk(plan)
    talk.exchange.receive(encode(LOG, log_payload(LogLine(1, f"firmware 1 of {THEIRS}"))), 0.0)

    assert not talk.exchange.refused


def test_a_controller_that_was_exchanged_in_a_mission_ends_it(plan: LinkPlan) -> None:
    """A line that survives the exchange, as that of a network, is silent meanwhile."""
    talk = told(plan, f"firmware 1 of {OURS}", running=True)
    talk.speaking = talk.echoing = False
    talk.run(1.0)
    talk.exchange.receive(encode(LOG, log_payload(LogLine(1, f"firmware 1 of {THEIRS}"))), talk.now)
    talk.speaking = talk.echoing = True
    talk.run(0.1)

    assert [fault for fault in talk.faults if THEIRS in fault]
    talk.arrays.clear()
    talk.submit(7, CLAMPING)
    talk.run(1.0)
    assert talk.arrays, "what is to be held is written all the same"
    assert "accepted" not in {result.status for result in talk.results}
