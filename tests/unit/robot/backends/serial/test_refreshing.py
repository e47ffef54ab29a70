"""The array in force is repeated, so that the firmware's dead man's switch does not trip."""

from __future__ import annotations

from itertools import pairwise

import pytest

from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.health import LineQuality, Refreshing
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import OVERHEAD_BYTES, Decoder

from .device import NUMBERS, Device, VirtualPort
from .test_backend import CLAMPING, run, run_port

EVERY_S, STOP_AFTER_S = 0.2, 0.5
LEAST_S = 0.03
SLOTS = 18


@pytest.fixture
def backend(plan: LinkPlan, port: VirtualPort) -> SerialBackend:
    backend = SerialBackend(plan, port)
    backend.open()
    return backend


def arrays(port: VirtualPort) -> list[tuple[float, bytes]]:
    """When arrays were written, and their payloads."""
    found = []
    for at_s, data in port.written:
        for frame in Decoder().feed(data):
            if frame.topic == NUMBERS["setpoints"]:
                found.append((at_s, frame.payload))
    return found


def test_the_array_in_force_is_repeated_when_nothing_else_is_written(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.submit(1, CLAMPING)
    run(backend, 5.0)

    gaps = [late - early for (early, _), (late, _) in pairwise(arrays(port))]
    assert len(gaps) >= 20
    assert max(gaps) < EVERY_S + 0.03, "answers to questions for the time go first"
    assert len({counts for _, _, counts in device.applied}) == 1
    assert backend.exchange.counts.repeats == 0
    assert backend.exchange.counts.refreshes == len(gaps)


def test_it_takes_four_percent_of_the_line(plan: LinkPlan) -> None:
    assert plan.serial.refresh_every is not None
    size = len(plan.messages.setpoints.pack(1, [0] * SLOTS)) + OVERHEAD_BYTES
    share = size / plan.serial.refresh_every / (plan.serial.baud / 10)

    assert share == pytest.approx(0.042, abs=0.001)


def test_nothing_is_repeated_before_the_first_array(
    backend: SerialBackend, port: VirtualPort
) -> None:
    run(backend, 5.0)

    assert arrays(port) == []


def test_nothing_is_repeated_while_the_controller_is_silent(
    backend: SerialBackend, device: Device, port: VirtualPort
) -> None:
    backend.submit(1, CLAMPING)
    run(backend, 1.0)
    device.hung_until_s = port.now() + 3.0
    silent_s = port.now()
    run_port(backend, port, 2.5)

    assert [at_s for at_s, _ in arrays(port) if at_s > silent_s + 0.5] == []


def test_slots_that_a_position_loop_drives_are_marked_to_be_stopped(
    backend: SerialBackend, port: VirtualPort, plan: LinkPlan
) -> None:
    backend.submit(1, CLAMPING)
    backend.hold(CLAMPING, {4, 6})
    run(backend, 0.1)

    hold = plan.messages.setpoints.unpack(arrays(port)[-1][1]).hold
    assert hold is not None
    stopped = {slot for slot in range(SLOTS) if not hold >> slot & 1}
    assert stopped == {4, 6, *plan.safe_zero}


def test_the_frame_that_the_guardian_sends_holds_all_but_the_wheels(
    backend: SerialBackend, plan: LinkPlan
) -> None:
    backend.submit(1, CLAMPING)
    backend.hold(CLAMPING, {4, 6})
    run(backend, 0.5)
    [frame] = Decoder().feed(backend.exchange.safe_frame())

    hold = plan.messages.setpoints.unpack(frame.payload).hold
    assert hold is not None
    assert {slot for slot in range(SLOTS) if not hold >> slot & 1} == set(plan.safe_zero)


def test_a_trip_is_counted_and_said_and_the_array_in_force_is_written_again_at_once(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    driving = tuple(1.0 if slot in plan.safe_zero else value for slot, value in enumerate(CLAMPING))
    backend.submit(1, driving)
    run(backend, 0.5)
    codec = plan.messages.setpoints
    last = codec.unpack(arrays(port)[-1][1])
    left = tuple(0 if slot in plan.safe_zero else n for slot, n in enumerate(last.counts))
    tripped_s = port.now()
    device.echoes.append((tripped_s, codec.pack(last.number, left, last.hold or 0)))
    told = run(backend, 1.0)

    assert told == [each for each in told if type(each[1]).__name__ == "SensorFrame"], "no fault"
    assert backend.exchange.counts.trips == 1
    assert backend.exchange.counts.damaged == 0
    assert backend.health.trips == 1
    assert backend.remark() == (
        "the robot's dead man's switch had stopped its motors because no setpoints arrived; "
        "they are sent again (1 time so far)"
    )
    assert backend.remark() == ""
    again_s = next(at_s for at_s, _ in arrays(port) if at_s > tripped_s)
    assert again_s - tripped_s < 0.07


def test_an_echo_with_another_mask_than_was_written_is_damage(
    backend: SerialBackend, device: Device, port: VirtualPort, plan: LinkPlan
) -> None:
    backend.submit(1, CLAMPING)
    run(backend, 0.5)
    codec = plan.messages.setpoints
    last = codec.unpack(arrays(port)[-1][1])
    device.echoes.append((port.now(), codec.pack(last.number, last.counts, 0)))
    run(backend, 0.6)

    assert backend.exchange.counts.damaged == 1


@pytest.mark.parametrize(
    ("lost", "interval_s"), [(0.0, 0.2), (0.05, 0.125), (0.3, 0.0625), (0.5, 0.0357), (0.9, 0.03)]
)
def test_repeats_come_faster_where_more_is_lost(lost: float, interval_s: float) -> None:
    found_s = Refreshing(EVERY_S, STOP_AFTER_S).interval_s(lost, LEAST_S)

    assert found_s == pytest.approx(interval_s, abs=1e-4)
    if interval_s > LEAST_S:
        assert lost ** int(STOP_AFTER_S / found_s + 1e-6) <= 1e-4, "the chance of a trip"


def test_without_a_switch_repeats_keep_their_pace() -> None:
    assert Refreshing(EVERY_S).interval_s(0.5, LEAST_S) == EVERY_S


@pytest.mark.parametrize(("answered", "lost"), [(1.0, 0.0), (0.64, 0.2), (0.25, 0.5)])
def test_what_is_lost_one_way_is_the_root_of_what_is_answered(answered: float, lost: float) -> None:
    quality = LineQuality(0.15)
    for _ in range(200):
        quality.lose(1 - answered)

    assert quality.lost_one_way == pytest.approx(lost, abs=0.01)


def test_bytes_that_turn_out_damaged_late_are_never_more_than_all() -> None:
    quality = LineQuality(0.15)
    quality.listened(1_000, 100_000)

    assert 0.5 < quality.lost_one_way < 1.0
    assert quality.bad


def test_refreshes_that_are_not_echoed_tell_of_a_bad_line(
    backend: SerialBackend, device: Device
) -> None:
    backend.submit(1, CLAMPING)
    run(backend, 0.5)
    assert not backend.exchange.link.quality.bad
    device.echo_s = 1000.0
    run(backend, 5.0)

    assert backend.exchange.link.quality.bad
