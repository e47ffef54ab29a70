"""The driver against a small device in virtual time: start, arrays, faults, the way out."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import inf, isnan, nan
from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import encode
from pirate_sm.robot.rosserial.messages import read_messages

from .conftest import without_refresh
from .device import NUMBERS, Device, VirtualPort

STILL = (0.0,) * 18
CLAMPING = (0.0,) * 4 + (-0.7, 1.0, 0.7, -1.0) + (0.0,) * 10


def run(backend: SerialBackend, until_s: float) -> list[tuple[float, Event]]:
    told: list[tuple[float, Event]] = []
    while True:
        now_s, events = backend.advance(until_s)
        told += [(now_s, event) for event in events]
        if now_s >= until_s and not events:
            return told


def run_port(backend: SerialBackend, port: VirtualPort, seconds: float) -> None:
    """So much time of the port has passed; mission time may have stood still."""
    end_s = port.now() + seconds
    while port.now() < end_s:
        backend.advance(backend.advance(0.0)[0] + end_s - port.now())


def clamp(backend: SerialBackend) -> None:
    """Open the link and have the clamping array confirmed: a second of the mission has passed."""
    backend.open()
    backend.submit(1, CLAMPING)
    run(backend, 1.0)


def results(told: list[tuple[float, Event]]) -> list[SubmitResult]:
    return [event for _, event in told if isinstance(event, SubmitResult)]


def faults(told: list[tuple[float, Event]]) -> list[FaultReport]:
    return [event for _, event in told if isinstance(event, FaultReport)]


def stalling(
    port: VirtualPort, monkeypatch: pytest.MonkeyPatch, when: Callable[[], bool], stall_s: float
) -> None:
    """Let this program stand still once, while it waits for reports."""
    read = port.read

    def stalled(until_s: float) -> bytes:
        if not when():
            return read(until_s)
        monkeypatch.setattr(port, "read", read)
        port.wait(port.now() + stall_s)
        return read(port.now() + 0.1)

    monkeypatch.setattr(port, "read", stalled)


@pytest.fixture(scope="module")
def plan(plan: LinkPlan) -> LinkPlan:
    """Arrays are not repeated here, so that each writing has a reason of its own."""
    return without_refresh(plan)


@pytest.fixture
def backend(plan: LinkPlan, port: VirtualPort) -> SerialBackend:
    return SerialBackend(plan, port)


# --- start ----------------------------------------------------------------------------------


def test_it_is_ready_once_every_fitted_board_has_spoken_and_has_moved_nothing(
    backend: SerialBackend, device: Device, plan: LinkPlan
) -> None:
    told = backend.open()

    assert {event.board for event in told if isinstance(event, SensorFrame)} == set(plan.channels)
    assert device.applied == []


def test_it_is_silent_while_the_boot_loader_listens(
    backend: SerialBackend, port: VirtualPort, plan: LinkPlan
) -> None:
    backend.open()

    assert port.written[0][0] >= plan.serial.boot


def test_it_answers_requests_for_the_time(backend: SerialBackend, device: Device) -> None:
    backend.open()
    run(backend, 1.0)

    replies = [payload for _, topic, payload in device.received if topic == 10]
    assert replies
    assert int.from_bytes(replies[0][:4], "little") == pytest.approx(1.7e9, abs=10)


def test_a_device_that_says_nothing(plan: LinkPlan) -> None:
    with pytest.raises(BackendError, match="nothing answers on virtual at 57600 baud"):
        SerialBackend(plan, VirtualPort(None)).open()


class Chatter(Device):
    words = b""

    def run(self, now: float) -> list[bytes]:
        self.next_s = now + 0.1
        return [self.words]

    def receive(self, data: bytes, now: float) -> list[bytes]:
        return []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (b"T=21.3 C, door open\r\n", "not speak rosserial, it sends 'T=21.3 C, door open"),
        (bytes(range(120, 250, 7)), "make no sense at 57600 baud: the firmware uses another speed"),
    ],
)
def test_a_device_that_speaks_something_else(plan: LinkPlan, words: bytes, message: str) -> None:
    device = Chatter(plan)
    device.words = words

    with pytest.raises(BackendError, match=message):
        SerialBackend(plan, VirtualPort(device)).open()


def test_another_definition_of_a_message_is_told_once_with_both_sums_and_our_text(
    backend: SerialBackend, device: Device, plan: LinkPlan
) -> None:
    device.md5["state"] = "f" * 32
    with pytest.raises(BackendError) as caught:
        backend.open()

    text = str(caught.value)
    assert "f" * 32 in text
    assert plan.messages.state.type.md5 in text
    assert plan.messages.state.type.text in text
    assert text.count("md5") == 1


def test_a_wrong_definition_causes_no_storm_of_requests(plan: LinkPlan, device: Device) -> None:
    device.md5["state"] = "f" * 32
    with pytest.raises(BackendError):
        SerialBackend(plan, VirtualPort(device)).open()

    assert device.requests <= 3


def test_a_device_without_a_topic_is_told_with_what_it_offers(
    backend: SerialBackend, device: Device
) -> None:
    device.topics = ("state", "setpoints")

    with pytest.raises(BackendError, match=r"not announce setpoint_echo .*It offers setpoint_arr"):
        backend.open()


def test_sensors_that_are_switched_off(backend: SerialBackend, device: Device) -> None:
    device.speaks = False

    with pytest.raises(BackendError, match=r"no board sends any value: push \[Set\] on"):
        backend.open()


def test_one_silent_board_is_a_fault_that_a_mission_may_handle(
    backend: SerialBackend, device: Device
) -> None:
    gone = min(device.boards)
    del device.boards[gone]

    told = backend.open()

    assert [e.code for e in told if isinstance(e, FaultReport)] == ["sensor.silent"]


def test_a_channel_that_says_nothing_is_passed_on_as_that(
    backend: SerialBackend, device: Device
) -> None:
    backend.open()
    device.boards[24][3] = nan
    told = run(backend, 1.0)

    last = [e for _, e in told if isinstance(e, SensorFrame) and e.board == 24][-1]
    assert isnan(last.values[3])
    assert not isnan(last.values[2])


# --- arrays ---------------------------------------------------------------------------------


def test_an_array_is_accepted_when_it_has_been_echoed(
    backend: SerialBackend, device: Device
) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    told = run(backend, 1.0)

    assert results(told) == [SubmitResult(1, "accepted")]
    assert [counts[4:8] for _, _, counts in device.applied] == [(-700, 1000, 700, -1000)]


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ((1.01, *STILL[1:]), "camera_tilt = 1.01 is beyond its limit of 1"),
        ((nan, *STILL[1:]), "camera_tilt is no number"),
        ((*STILL[:10], 2.0, *STILL[11:]), "rotate = 2 is beyond its limit"),
        (STILL[1:], "17 values for 18 slots"),
    ],
)
def test_an_array_beyond_the_limits_is_rejected_and_never_sent(
    backend: SerialBackend, device: Device, values: tuple[float, ...], reason: str
) -> None:
    backend.open()
    backend.submit(1, values)
    [result] = results(run(backend, 1.0))

    assert result.status == "rejected"
    assert reason in result.reason
    assert device.applied == []


def test_an_array_that_was_not_sent_yet_is_superseded_by_a_newer_one(
    backend: SerialBackend, device: Device
) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    run(backend, 0.03)
    backend.submit(2, STILL)
    backend.submit(3, CLAMPING)
    told = run(backend, 1.0)

    assert [(r.setpoint_id, r.status) for r in results(told)] == [
        (2, "superseded"),
        (1, "accepted"),
        (3, "accepted"),
    ]
    assert len(device.applied) == 2


def test_without_echoes_the_fate_is_unknown_after_a_few_copies(
    backend: SerialBackend, device: Device
) -> None:
    device.echo_s = 1000.0
    backend.open()
    backend.submit(1, CLAMPING)
    told = run(backend, 3.0)

    assert [(r.setpoint_id, r.status) for r in results(told)] == [(1, "unknown")]
    assert 3 < len(device.applied) < 50
    assert len({counts for _, _, counts in device.applied}) == 1


def test_a_damaged_array_is_found_by_its_echo_and_corrected_within_a_round_trip(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    run(backend, 0.5)
    wrong = device.plan.messages.setpoints.pack(9, [5] * 18)
    port.post("device", encode(NUMBERS["setpoints"], wrong))
    told = run(backend, 1.0)

    assert [counts[0] for _, _, counts in device.applied] == [0, 5, 0]
    assert device.applied[2][0] - device.applied[1][0] < 0.1
    assert backend.exchange.link.damaged == 1
    assert results(told) == []


@pytest.mark.parametrize("seed", thorough_but([0], range(4)))
def test_a_bad_line_loses_no_array_and_brings_none_after_a_newer_one(
    plan: LinkPlan, seed: int
) -> None:
    device = Device(plan)
    port = VirtualPort(device, seed=seed, loss=0.2, damage=0.01)
    backend = SerialBackend(plan, port)
    backend.open()
    wanted, told = [], []
    for number in range(1, 101):
        wheel = number / 1000
        wanted.append((*STILL[:5], wheel, *STILL[6:]))
        while True:
            backend.submit(number, wanted[-1])
            start = backend.advance(0.0)[0]
            fresh: list[SubmitResult] = []
            while not fresh:
                start, events = backend.advance(start + 10.0)
                told += [(start, event) for event in events]
                fresh = [e for e in events if isinstance(e, SubmitResult)]
            if fresh[-1].status == "accepted":
                break
            assert fresh[-1].status == "unknown"
    sequence = [counts[5] for _, _, counts in device.applied if max(map(abs, counts)) <= 100]
    clean = [c for c in sequence if c in range(1, 101)]

    assert sorted(set(clean)) == list(range(1, 101))
    assert not [e for e in faults(told) if e.code != "sensor.spiking"]


def test_no_two_arrays_are_under_way_and_the_ring_of_the_device_never_overruns(
    backend: SerialBackend, port: VirtualPort, device: Device
) -> None:
    backend.open()
    for number in range(1, 200):
        backend.submit(number, (*STILL[:5], number / 1000, *STILL[6:]))
        run(backend, number * 0.01)
    arrays = [at for at, data in port.written if len(data) == 48]
    echoes = 0.05

    assert min(b - a for a, b in pairwise(arrays)) >= echoes
    for at, _ in port.written:
        recent = sum(len(data) for t, data in port.written if at - 0.02 < t <= at)
        assert recent <= 64


# --- what goes wrong on the way --------------------------------------------------------------


def test_a_reset_is_told_once_the_safe_array_is_confirmed_and_then_the_last_one_repeated(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.reset(port.now())
    before = len(device.applied)
    told = run(backend, 2.0)

    [fault] = faults(told)
    assert fault.code == "firmware.reset"
    assert fault.message.startswith("the robot's controller said nothing for 1.")
    assert fault.message.endswith("it has confirmed that the safe setpoints have arrived")
    assert 1.0 <= fault.away_s < 2.0
    assert [counts[4:8] for _, _, counts in device.applied[before:]] == [
        (-700, 0, 700, 0),
        (-700, 1000, 700, -1000),
    ]
    assert backend.exchange.link.idle


def test_after_a_reset_no_wheel_turns_when_whoever_was_told_wants_it_to_stop(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.reset(port.now())
    before, now_s, told = len(device.applied), 1.0, []
    while not told:
        now_s, events = backend.advance(4.0)
        told = [event for event in events if isinstance(event, FaultReport)]
    backend.submit(2, (*CLAMPING[:5], 0.0, 0.7, 0.0, *CLAMPING[8:]))
    run(backend, now_s + 1.0)

    assert {counts[4:8] for _, _, counts in device.applied[before:]} == {(-700, 0, 700, 0)}


def test_mission_time_stands_still_while_a_controller_starts_again(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.open()
    opened_s = port.now()
    run(backend, 1.0)
    device.reset(port.now())
    told = run(backend, 2.0)
    at_s = next(at for at, event in told if isinstance(event, FaultReport))

    assert at_s == pytest.approx(1.4, abs=0.05)  # a silence begins to count after 0.4 s
    assert port.now() - opened_s > 2.6
    frames = [event.board for at, event in told if at == at_s and isinstance(event, SensorFrame)]
    assert set(frames) == set(device.boards)


def test_mission_time_does_not_count_a_stall_of_this_program_in_which_the_cable_went(
    backend: SerialBackend, port: VirtualPort
) -> None:
    """The mission saw more than 1 s without a reading: all boards silent, no way to handle it."""
    backend.open()
    run(backend, 1.0)
    port.plugged = False
    port.time_s += 1.5
    now_s, _ = backend.advance(10.0)

    assert now_s == pytest.approx(1.4, abs=0.05)


@pytest.mark.parametrize("queued", [True, False])
def test_a_standstill_of_this_program_is_no_silence_of_the_controller(
    backend: SerialBackend, port: VirtualPort, queued: bool
) -> None:
    """A mission ended with `firmware.reset` when the whole computer had stood still for 1 s."""
    backend.open()
    run(backend, 1.0)
    port.wait(port.now() + 1.2)
    if not queued:  # the guardian had stood still as well, and nothing was kept
        while port.read(port.now()):
            pass
    now_s, events = backend.advance(10.0)
    assert now_s == pytest.approx(1.4, abs=0.05), "only what it takes to notice a silence"
    told = run(backend, 4.0)

    assert not faults([(now_s, event) for event in events] + told)


def test_belief_no_board_was_silent_while_this_program_stood_still_as_it_waited_for_reports(
    backend: SerialBackend, port: VirtualPort, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was `sensor.silent`: 1.2 s had passed in the mission when the first board was heard."""
    backend.open()
    run(backend, 1.0)
    stalling(port, monkeypatch, lambda: True, 1.2)

    now_s, events = backend.advance(10.0)
    told = [(now_s, event) for event in events] + run(backend, 4.0)

    assert now_s == pytest.approx(1.4, abs=0.05)
    assert not faults(told)


@pytest.mark.parametrize("stall_s", [0.3, 0.6, 1.0])
def test_belief_an_outage_is_not_forgotten_when_this_program_stands_still_in_it(
    backend: SerialBackend,
    device: Device,
    port: VirtualPort,
    monkeypatch: pytest.MonkeyPatch,
    stall_s: float,
) -> None:
    """The last silence alone was short, so it was no fault that the controller had hung."""
    clamp(backend)
    device.hung_until_s = port.now() + 1.5

    def is_back() -> bool:
        outage = backend.exchange.outage
        return outage is not None and outage.back

    stalling(port, monkeypatch, is_back, stall_s)

    assert [each.code for each in faults(run(backend, 3.0))] == ["firmware.reset"]


@pytest.mark.parametrize("stall_s", [0.3, 0.6, 1.0])
def test_a_standstill_as_an_outage_is_judged_adds_nothing_to_mission_time(
    backend: SerialBackend,
    device: Device,
    port: VirtualPort,
    monkeypatch: pytest.MonkeyPatch,
    stall_s: float,
) -> None:
    """The silence of the controller, which mission time leaves out, had passed in it."""
    backend.open()
    run(backend, 1.0)
    device.hung_until_s = port.now() + 1.5
    stalling(port, monkeypatch, lambda: backend.exchange.aside, stall_s)

    (told_s,) = [at for at, each in run(backend, 3.0) if isinstance(each, FaultReport)]

    assert told_s == pytest.approx(1.4, abs=0.05)


def test_nothing_is_told_of_sensors_before_the_reset_is(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.open()
    run(backend, 1.0)
    device.reset(port.now())
    told = [event for at, event in run(backend, 2.0) if at > 1.1]

    assert isinstance(told[0], FaultReport)
    assert told[0].message.endswith("it was reset or hung: nothing had been sent to it before")


def test_it_is_known_for_how_long_a_silent_link_is_waited_for(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    clamp(backend)
    assert backend.health.patience_s == 0.0
    device.boot_s = 1000.0
    device.reset(port.now())
    while not backend.health.trouble:
        backend.advance(10.0)
    health = backend.health

    assert health.silent_s + health.patience_s == pytest.approx(plan.away_s, abs=0.05)


def test_a_controller_that_does_not_come_back_is_a_silent_link(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    clamp(backend)
    device.boot_s = 1000.0
    began_s = port.now()
    device.reset(began_s)
    told = run(backend, 3.0)

    assert [fault.code for fault in faults(told)] == ["link.silent"]
    assert faults(told)[0].message == (
        "the robot's controller has been silent for 8.0 s, however often it was asked"
    )
    assert plan.away_s == 8.0


def test_a_controller_that_comes_back_and_does_not_confirm_is_told_as_that(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.reset(port.now())
    device.echo_s = 1000.0
    told = run(backend, 3.0)

    assert [fault.code for fault in faults(told)] == ["link.no_echo"]
    assert "is back after 1." in faults(told)[0].message
    assert "does not confirm the safe setpoints" in faults(told)[0].message


def test_a_second_reset_while_the_first_is_looked_into_is_one_fault(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.reset(port.now())
    while not device.configured:
        backend.advance(5.0)
    device.reset(port.now())
    told = run(backend, 3.0)

    assert [fault.code for fault in faults(told)] == ["firmware.reset"]
    assert device.applied[-1][2][4:8] == (-700, 1000, 700, -1000)


@pytest.mark.parametrize("silence_s", [0.45, 0.55, 0.69])
def test_a_line_that_is_silent_for_a_moment_is_no_fault_and_takes_no_mission_time(
    backend: SerialBackend, port: VirtualPort, silence_s: float
) -> None:
    backend.open()
    opened_s = port.now()
    run(backend, 1.0)
    port.deaf_until_s = port.now() + silence_s
    told = run(backend, 3.0)

    assert faults(told) == []
    assert port.now() - opened_s == pytest.approx(3.0, abs=0.01)
    assert [at for at, _ in told] == sorted(at for at, _ in told)


def test_a_silence_that_is_given_up_takes_no_mission_time_after_one_that_was_brief(
    backend: SerialBackend, port: VirtualPort
) -> None:
    backend.open()
    run(backend, 1.0)
    port.deaf_until_s = port.now() + 0.55
    run(backend, 3.0)
    port.deaf_until_s = inf
    told = run(backend, 5.0)

    [at_s] = [at for at, event in told if isinstance(event, FaultReport)]
    assert at_s == pytest.approx(3.4, abs=0.05)


def test_a_controller_that_hangs_and_goes_on_is_taken_for_one_that_was_reset(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    before = len(device.applied)
    device.hung_until_s = port.now() + 1.5
    told = run(backend, 3.0)

    [fault] = faults(told)
    assert fault.code == "firmware.reset"
    assert fault.message.startswith("the robot's controller said nothing for 1.5 s, it was reset ")
    assert device.applied[before][2][4:8] == (-700, 0, 700, 0)


def test_a_robot_that_was_unplugged_and_is_back_is_an_interruption_and_goes_on_from_its_safe_state(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    clamp(backend)
    before = len(device.applied)
    port.plugged = False
    run_port(backend, port, 3.0)
    port.plugged = True
    told = run(backend, 3.0)

    [fault] = faults(told)
    assert fault.code == "link.interrupted"
    boot_s = plan.serial.boot
    away_s = float(fault.message.removeprefix("the link was away for ").split(" s ")[0])
    assert away_s == pytest.approx(3.5 + boot_s, abs=0.3), "unplugged, opened, booting"
    assert "(unplugged) and is back: it has confirmed that the safe" in fault.message
    assert [counts[4:8] for _, _, counts in device.applied[before:]] == [
        (-700, 0, 700, 0),
        (-700, 1000, 700, -1000),
    ]
    assert port.opened == 2


def test_a_robot_that_stays_unplugged_is_a_lost_link_and_still_stopped_should_it_come_back(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    port.plugged = False
    told = run(backend, 1.5)
    backend.submit(2, STILL)
    told += run(backend, 3.5)
    port.plugged = True
    backend.submit(2, STILL)
    told += run(backend, 9.0)

    assert [fault.code for fault in faults(told)] == ["link.lost"]
    assert faults(told)[0].message == (
        "the link to the robot is lost: unplugged, and was not back 8.0 s later"
    )
    assert results(told)[0][:2] == (2, "unknown")
    assert device.applied[-1][2] == (0,) * 18


def test_another_definition_after_a_reset_is_a_fault_at_once(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.md5["echo"] = "f" * 32
    device.reset(port.now())
    told = run(backend, 3.0)

    assert [fault.code for fault in faults(told)] == ["link.mismatch"]
    assert "is another one than ours" in faults(told)[0].message


def test_the_guardian_knows_the_safe_frame_while_topics_are_asked_for_again(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    frame = port.safe_frame
    port.plugged = False
    run_port(backend, port, 1.0)
    port.plugged = True
    run_port(backend, port, 1.0)

    assert frame
    assert port.safe_frame == frame


# --- the way out -----------------------------------------------------------------------------


def test_the_last_array_submitted_goes_out_before_the_port_is_closed(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    backend.submit(2, STILL)
    backend.close()

    assert device.applied[-1][2] == (0,) * 18
    assert device.received[-1][1] == 11
    assert port.closed


def test_the_way_out_waits_for_a_controller_that_starts_again_and_has_it_confirm(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    clamp(backend)
    device.reset(port.now())
    run(backend, 1.4)
    run_port(backend, port, 0.1)
    backend.close()

    assert device.applied[-1][2][4:8] == (-700, 0, 700, 0)
    assert device.received[-1][1] == 11


@pytest.mark.parametrize("obeys", [True, False])
def test_only_a_confirmed_stop_dismisses_the_guardian_and_ends_the_conversation(
    backend: SerialBackend, device: Device, port: VirtualPort, obeys: bool
) -> None:
    backend.open()
    driving = [*STILL]
    driving[backend.plan.safe_zero[0]] = 0.5
    backend.submit(1, tuple(driving))
    run(backend, 0.5)
    assert not backend.exchange.stopped.confirmed
    device.hung_until_s = 0.0 if obeys else 1e9
    backend.submit(2, STILL)
    backend.close()

    assert port.stopped is obeys
    assert (port.written[-1][1] == encode(11)) is obeys


def test_closing_gives_up_on_a_device_that_stays_away(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    clamp(backend)
    device.boot_s = 1000.0
    device.reset(port.now())
    backend.submit(2, STILL)
    run_port(backend, port, 0.5)
    began_s = port.now()
    backend.close()

    assert port.now() - began_s < plan.away_s + 1.0
    assert port.closed


def test_what_has_been_closed_cannot_be_opened_again(
    backend: SerialBackend, device: Device
) -> None:
    backend.open()
    backend.close()

    with pytest.raises(BackendError, match="the port has been closed"):
        backend.open()


def test_the_safe_frame_holds_the_clamps_and_stops_the_wheels(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.open()
    assert port.safe_frame == b""
    backend.submit(1, CLAMPING)
    run(backend, 1.0)
    port.post("device", port.safe_frame)
    port.wait(port.now() + 0.1)

    assert device.applied[-1][1] == 0
    assert device.applied[-1][2] == (0, 0, 0, 0, -700, 0, 700, 0, *(0,) * 10)


def test_the_array_that_is_to_be_held_stands_in_the_safe_frame(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.open()
    backend.submit(1, CLAMPING)
    backend.hold((*CLAMPING[:6], 0.0, *CLAMPING[7:]))
    run(backend, 1.0)
    port.post("device", port.safe_frame)
    port.wait(port.now() + 0.1)

    assert device.applied[-1][2][4:8] == (-700, 0, 0, 0)


def test_one_value_at_a_time_makes_whole_boards(plan: LinkPlan, tmp_path: Path) -> None:
    for kind in (plan.messages.setpoints.type, plan.messages.echo.type):
        (tmp_path / f"{kind.name.partition('/')[2]}.msg").write_text(kind.text)
    (tmp_path / "State.msg").write_text("uint8 board\r\nuint8 channel\r\nfloat32 value\r\n")
    state = plan.serial.state.model_copy(update={"layout": "value"})
    serial = plan.serial.model_copy(update={"state": state})
    messages = read_messages(tmp_path, serial, len(plan.slots))
    wanted = plan.wanted[2]._replace(md5=messages.state.type.md5)
    one = plan._replace(serial=serial, messages=messages, wanted=(*plan.wanted[:2], wanted))
    device = Device(one)
    device.boards = {b: [float(10 * b + c) for c in range(n)] for b, n in plan.channels.items()}
    backend = SerialBackend(one, VirtualPort(device))
    backend.open()
    frames = [e for _, e in run(backend, 3.0) if isinstance(e, SensorFrame)]

    assert messages.state.type.md5 == "704cdcb7b128fe0240339af8c705abae"
    assert {f.board: f.values for f in frames} == {
        b: tuple(values) for b, values in device.boards.items()
    }


def test_what_was_never_opened_leaves_nothing_unconfirmed(backend: SerialBackend) -> None:
    backend.close()

    assert backend.confirmed


def test_the_trouble_with_a_port_that_is_gone_is_told_in_its_own_words(
    backend: SerialBackend, port: VirtualPort
) -> None:
    backend.open()
    run(backend, 1.0)
    port.plugged = False
    run_port(backend, port, 1.0)

    assert backend.health.trouble == "unplugged"
