"""The link is served while nobody runs a mission on it, and a robot at rest needs no guardian."""

from __future__ import annotations

from threading import Event

import pytest

from benchmarks.resume_rides import World, prepared_on, world
from pirate_sm.core.events import FaultReport, SensorFrame
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.simulation.bay.virtual import VirtualPort as BayPort

from .device import Device, VirtualPort

STILL = (0.0,) * 18
DRIVING = tuple(float(slot in range(5, 16, 2)) for slot in range(18))
"""Every wheel is driven."""
MINUTE_S = 60.0
WALL_S = 30.0


def think(backend: SerialBackend, seconds: float) -> None:
    """A person thinks for so long, while the backend serves the link."""
    until_s = backend.port.now() + seconds
    while backend.port.now() < until_s:
        before_s = backend.port.now()
        backend.tend()
        assert backend.port.now() > before_s, "nobody serves the link"


def told(backend: SerialBackend, until_s: float) -> list[object]:
    found: list[object] = []
    now_s = 0.0
    while now_s < until_s:
        now_s, events = backend.advance(until_s)
        found += events
    return found


@pytest.fixture
def bay() -> World:
    """A bay whose firmware falls silent when nobody answers its questions for 11 s."""
    return world("prepare_bend", 0)


@pytest.fixture
def on_bay(bay: World) -> SerialBackend:
    backend = prepared_on(bay, bay.port).backend
    assert isinstance(backend, SerialBackend)
    backend.open()
    return backend


def test_belief_a_robot_is_known_as_before_after_somebody_has_thought_for_a_minute(
    on_bay: SerialBackend, bay: World
) -> None:
    """It was `link.silent`: reports had piled up, and the controller had lost its host."""
    told(on_bay, 1.0)
    think(on_bay, MINUTE_S)
    now_s, events = on_bay.advance(2.0)
    frames = [each.board for each in events if isinstance(each, SensorFrame)]

    assert now_s < 1.1, "mission time has stood still"
    assert len(frames) <= len(bay.loaded.robot.boards) + 1, "old reports are dropped"
    assert not [each for each in (*events, *told(on_bay, 5.0)) if isinstance(each, FaultReport)]
    assert bay.bay.configured


def test_belief_a_mission_goes_on_after_a_minute_in_which_nobody_ran_it(bay: World) -> None:
    prepared = prepared_on(bay, bay.port)
    pump = Pump(prepared.engine, prepared.backend, companions=prepared.companions)
    pump.start(paused=True)
    while pump.now_s < 2.0:
        pump.take(*pump.wait(2.0))
    assert isinstance(prepared.backend, SerialBackend)
    think(prepared.backend, MINUTE_S)
    while pump.now_s < 5.0:
        pump.take(*pump.wait(5.0))

    assert (pump.ended, pump.fault) == (None, "")


def test_a_fault_of_the_link_is_reported_after_the_thinking(
    on_bay: SerialBackend, bay: World
) -> None:
    bay.bay.robot.electronics.restart()
    bay.bay._reset(bay.port.now(), "a test")
    think(on_bay, 10.0)

    codes = [each.code for each in told(on_bay, 2.0) if isinstance(each, FaultReport)]

    assert codes == ["firmware.reset"]


def test_a_robot_that_may_be_moving_is_not_served_unwatched(plan: LinkPlan) -> None:
    port = VirtualPort(Device(plan))
    backend = SerialBackend(plan, port)
    backend.open()
    backend.submit(1, DRIVING)
    told(backend, 1.0)
    before_s = port.now()
    backend.tend()
    assert port.now() == before_s

    backend.submit(2, STILL)
    backend.tend()
    assert port.now() == before_s, "its stop is not confirmed yet"
    told(backend, 2.0)
    backend.tend()
    assert port.now() > before_s


def test_a_thread_serves_the_link_while_nobody_calls(plan: LinkPlan) -> None:
    passed = Event()

    class Watched(VirtualPort):
        def read(self, until_s: float) -> bytes:
            if self.now() > 5.0:
                passed.set()
            return super().read(until_s)

    backend = SerialBackend(plan, Watched(Device(plan)), tended=True)
    backend.open()
    try:
        assert passed.wait(WALL_S)
        assert not [each for each in told(backend, 1.0) if isinstance(each, FaultReport)]
    finally:
        backend.close()


def test_what_goes_wrong_while_nobody_calls_is_raised_at_the_next_call(plan: LinkPlan) -> None:
    broken = Event()

    class Breaking(VirtualPort):
        def read(self, until_s: float) -> bytes:
            if self.now() > 3.0 and not broken.is_set():
                broken.set()
                raise ValueError("broken")
            return super().read(until_s)

    backend = SerialBackend(plan, Breaking(Device(plan)), tended=True)
    backend.open()
    assert broken.wait(WALL_S)

    with pytest.raises(ValueError, match="broken"):
        told(backend, 1.0)
    backend.close()


# --- a program that stands still --------------------------------------------------------------


def stalled(backend: SerialBackend, port: BayPort, seconds: float) -> list[str]:
    """Faults after this program has stood still for so long."""
    port.wait(port.now() + seconds)
    until_s = backend.advance(0.0)[0] + 2.0
    return [each.code for each in told(backend, until_s) if isinstance(each, FaultReport)]


def test_belief_a_busy_computer_is_no_fault_of_a_robot_at_rest(
    on_bay: SerialBackend, bay: World
) -> None:
    """It was `runner.stalled`, eight times in 150 s, although nothing moved."""
    on_bay.submit(1, STILL)
    told(on_bay, 1.0)

    assert not stalled(on_bay, bay.port, 0.6)


def test_a_guardian_stops_a_robot_that_was_driven_when_its_program_stood_still(
    on_bay: SerialBackend, bay: World
) -> None:
    on_bay.submit(1, STILL)
    told(on_bay, 1.0)
    on_bay.submit(2, DRIVING)
    told(on_bay, 2.0)

    assert stalled(on_bay, bay.port, 0.6) == ["runner.stalled"]


def test_the_guardian_knows_what_stops_the_robot_before_it_drives(bay: World) -> None:
    """A program that stands still between two writings must not leave it driving."""
    known: list[bool] = []

    class Watched(BayPort):
        def write(self, data: bytes) -> None:
            known.append(bool(self._guard.payload))
            super().write(data)

    port = Watched(bay.bay, 0.25)
    backend = prepared_on(bay, port).backend
    backend.open()
    backend.submit(1, STILL)
    told(backend, 1.0)
    assert not port._guard.payload, "at rest"
    known.clear()
    backend.submit(2, DRIVING)
    told(backend, 1.2)

    assert known
    assert all(known)
