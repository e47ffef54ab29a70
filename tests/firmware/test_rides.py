"""Missions on what is flashed, and what happens to wheels and clamps if something dies in them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import pytest

from benchmarks.arrays import loaded_mission
from pirate_sm.core.events import BuiltInFault, FaultReport
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.simulation.bay.virtual import VirtualPort

from .avr_bay import AvrBay, Built
from .rides import STAND_WITHIN_S, KilledError, Ride
from .test_tables import SIX_WHEELED, of

pytestmark = [pytest.mark.firmware, pytest.mark.timeout(900)]

LEAST_STACK = 1000
"""Bytes that the stack must never have reached."""

NOISE = 0.0005
"""Share of bytes that are lost, and of those that are changed, on each line [assumed]."""

BENDS = [each if each < 5 else pytest.param(each, marks=pytest.mark.slow) for each in range(20)]
"""The seeds of the bends; the first five are taken by the build too."""

ROUNDS = pytest.mark.parametrize("rounds", [25, pytest.param(100, marks=pytest.mark.slow)])


@pytest.mark.parametrize("seed", BENDS)
def test_the_bend_is_passed_on_bad_lines_and_the_stack_has_room(
    six_wheeled: Built, seed: int
) -> None:
    ride = Ride(six_wheeled, seed, NOISE)

    result = ride.run()

    assert result.ended.outcome == "succeeded", result.ended
    assert ride.bay.still_since_s < ride.port.now()
    assert ride.bay.unused_stack() > LEAST_STACK


def test_wheels_stand_and_nothing_is_let_go_of_when_the_cable_is_unplugged(
    six_wheeled: Built,
) -> None:
    ride = Ride(six_wheeled)
    ride.port.sabotage = ride.port.unplug

    assert ride.run().ended.message.startswith("link.lost")
    assert ride.bay.still_since_s < ride.port.at_s + STAND_WITHIN_S
    assert {slot: ride.bay.counts[slot] for slot in ride.port.held} == ride.port.held


def test_wheels_stand_and_nothing_is_let_go_of_when_the_main_loop_hangs(
    six_wheeled: Built,
) -> None:
    ride = Ride(six_wheeled)
    ride.port.sabotage = lambda: ride.bay.controller.does("hang")

    ended = ride.run().ended

    assert ended.message.startswith("firmware.reset") or ended.outcome == "succeeded", ended
    words = [line.text for line in ride.backend.exchange.conversation.words]
    assert any("the watchdog restarted it" in line for line in words), words


@pytest.mark.parametrize("guardian", [True, False], ids=["guarded", "alone"])
def test_wheels_stand_and_nothing_is_let_go_of_when_the_host_is_killed(
    six_wheeled: Built, guardian: bool
) -> None:
    """Killed alone, and its guardian with it."""
    ride = Ride(six_wheeled)
    ride.port.sabotage = partial(ride.port.kill, guardian)

    with pytest.raises(KilledError):
        ride.run()

    assert ride.bay.still_since_s < ride.port.at_s + STAND_WITHIN_S
    assert {slot: ride.bay.counts[slot] for slot in ride.port.held} == ride.port.held


# --- again and again ------------------------------------------------------------------------------


class Drives:
    """The driver lets wheels turn and parts clamp; something dies; the robot is brought back."""

    CLAMPED = tuple(-0.7 if at == 4 else 0.7 if at == 14 else 0.0 for at in range(18))
    DRIVEN = tuple(1.0 if at == 5 else -1.0 if at == 7 else it for at, it in enumerate(CLAMPED))

    def __init__(self, built: Built) -> None:
        profile, plan = of(SIX_WHEELED)
        loaded = loaded_mission()
        starts = start_values(loaded)
        self.bay = AvrBay(built, profile, SIX_WHEELED, loaded.pipe, start_values=starts)
        # Behind no boot loader the binary runs immediately.
        self._plan = plan._replace(serial=plan.serial.model_copy(update={"boot": 0.05}))
        self.port = VirtualPort(self.bay, plan.serial.heartbeat_within)
        self.dies_s = 0.0
        self.connect()

    def connect(self) -> None:
        self.backend = SerialBackend(self._plan, self.port)
        self.backend.open()
        self._mission_s = 0.0

    def wait(self, for_s: float, fault: BuiltInFault | None = None) -> bool:
        """Let the driver run for this time, or until this fault; return whether it came."""
        until_s = self.port.now() + for_s
        while (left_s := until_s - self.port.now()) > 0:
            self._mission_s, events = self.backend.advance(self._mission_s + left_s)
            faults = [each.code for each in events if isinstance(each, FaultReport)]
            if fault is not None and fault.code in faults:
                return True
        return False

    def drive(self, number: int) -> None:
        """Drive for a moment that ends in another phase of the bus and of the repeats each time."""
        self.backend.hold(self.CLAMPED)
        self.backend.submit(number + 1, self.DRIVEN)
        self.wait(0.15 + number * 0.00216)
        assert not self.stands
        self.bay.in_force.clear()
        self._held = self.held
        self.dies_s = self.port.now()

    @property
    def stands(self) -> bool:
        return self.bay.still_since_s < self.port.now()

    @property
    def held(self) -> tuple[int, ...]:
        return self._not_wheels(self.bay.counts)

    def _drives(self, counts: Sequence[int]) -> bool:
        return any(counts[at] for at in self.bay.wheels)

    def _not_wheels(self, counts: Sequence[int]) -> tuple[int, ...]:
        return tuple(it for at, it in enumerate(counts) if at not in self.bay.wheels)

    def check(self) -> None:
        """Wheels stand in time and no wheel is driven again, and what was held is held."""
        at_s = next(at_s for at_s, counts in self.bay.in_force if not self._drives(counts))
        assert at_s < self.dies_s + STAND_WITHIN_S
        assert self.bay.still_since_s == at_s
        assert {self._not_wheels(counts) for _, counts in self.bay.in_force} == {self._held}
        assert any(self._held)


@pytest.fixture
def drives(six_wheeled: Built) -> Drives:
    return Drives(six_wheeled)


@ROUNDS
@pytest.mark.parametrize("guardian", [True, False], ids=["guarded", "alone"])
def test_a_host_that_is_killed_leaves_wheels_at_zero_and_clamps_held_every_time(
    drives: Drives, guardian: bool, rounds: int
) -> None:
    for number in range(rounds):
        drives.drive(number)
        if guardian:
            drives.port.die(drives.dies_s + 0.7)
        else:
            drives.port.abandon()
            drives.port.wait(drives.dies_s + 0.7)
        drives.check()
        drives.port = drives.port.next_port()
        drives.connect()


@ROUNDS
def test_a_cable_that_is_out_leaves_wheels_at_zero_and_clamps_held_every_time(
    drives: Drives, rounds: int
) -> None:
    for number in range(rounds):
        drives.drive(number)
        drives.port.plugged = False
        drives.wait(0.7)
        drives.check()
        drives.port.plugged = True
        assert drives.wait(3.0, BuiltInFault.LINK_INTERRUPTED)


@ROUNDS
@pytest.mark.parametrize("hang", ["hang", "deaf"])
def test_a_main_loop_that_hangs_leaves_wheels_at_zero_and_clamps_held_every_time(
    drives: Drives, hang: str, rounds: int
) -> None:
    """Also one that hangs with interrupts switched off."""
    for number in range(rounds):
        drives.drive(number)
        drives.bay.controller.does(hang)
        assert drives.wait(3.0, BuiltInFault.FIRMWARE_RESET)
        drives.check()
    words = [line.text for line in drives.backend.exchange.conversation.words]
    assert any("the watchdog restarted it" in line for line in words), words
