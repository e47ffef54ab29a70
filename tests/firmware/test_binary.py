"""What is flashed, run in a simulated controller, with the production driver at the other end."""

from __future__ import annotations

from collections.abc import Sequence
from struct import pack

import pytest

from benchmarks.arrays import loaded_mission
from pirate_sm.core.errors import BackendError
from pirate_sm.core.loading import load_pipe
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.firmware_tables import tables_of
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import (
    LOG,
    REQUEST_TOPICS,
    TIME,
    TX_STOP,
    Decoder,
    SerialFrame,
    encode,
    read_log,
    time_payload,
)
from pirate_sm.simulation.bay.virtual import VirtualPort
from pirate_sm.simulation.kinematic.world import World
from pirate_sm.testing import BackendContract, Candidate
from tests.conformance.candidates import NEWT, candidate

from .avr_bay import AvrBay, Built
from .doctor import examined
from .rides import STAND_WITHIN_S
from .test_tables import SIX_WHEELED, of

pytestmark = [pytest.mark.firmware, pytest.mark.timeout(900)]

ROUNDS = 100


# --- a host of our own ----------------------------------------------------------------------------


def array(number: int, counts: Sequence[int], hold: int) -> bytes:
    """The payload of an array of the shipped robot."""
    return pack("<I18h", hold << 14 | number, *counts)


class Speaker:
    """A host that sends given frames, and answers requests for the time."""

    def __init__(self, built: Built) -> None:
        profile, _ = of(SIX_WHEELED)
        pipe = load_pipe(SIX_WHEELED.parents[1] / "sequences" / "pipes" / "straight_113.yaml")[0]
        self.bay = AvrBay(built, profile, SIX_WHEELED, pipe)
        self.now_s = 0.0
        self.frames: list[tuple[float, SerialFrame]] = []
        self._decoder = Decoder()
        self.bay.open(0.0)

    def wait(self, for_s: float, step_s: float = 0.004) -> None:
        until_s = self.now_s + for_s
        while self.now_s < until_s:
            self.now_s = min(self.now_s + step_s, until_s)
            for frame in self._decoder.feed(self.bay.advance(self.now_s)):
                self.frames.append((self.now_s, frame))
                if frame.topic == TIME:
                    self.send(TIME, time_payload(self.now_s))

    def send(self, topic: int, payload: bytes = b"") -> None:
        self.bay.receive(encode(topic, payload), self.now_s)

    def set(self, number: int, counts: list[int], hold: int) -> None:
        self.send(100, array(number, counts, hold))

    def on(self, topic: int) -> list[bytes]:
        return [frame.payload for _, frame in self.frames if frame.topic == topic]

    @property
    def words(self) -> list[str]:
        lines = [read_log(payload) for payload in self.on(LOG)]
        return [line.text for line in lines if line is not None]


@pytest.fixture
def speaker(six_wheeled: Built) -> Speaker:
    speaker = Speaker(six_wheeled)
    speaker.wait(0.05)
    speaker.send(0)
    speaker.wait(0.4)
    return speaker


HELD, DRIVEN = 1 << 4 | 1 << 14, [0] * 18
DRIVEN[4], DRIVEN[14], DRIVEN[5], DRIVEN[7] = -700, 700, 1000, -1000
STOPPED = [DRIVEN[4] if at == 4 else DRIVEN[14] if at == 14 else 0 for at in range(18)]


def test_a_silent_host_stops_what_is_not_held_in_every_phase_of_the_cycle(speaker: Speaker) -> None:
    for number in range(ROUNDS):
        speaker.wait(number * 0.00016)  # over a cycle of 16 ms
        speaker.set(number, DRIVEN, HELD)
        spoken_s = speaker.now_s
        speaker.wait(0.1)
        assert speaker.bay.counts == DRIVEN
        speaker.wait(0.52)
        assert speaker.bay.counts == STOPPED
        assert speaker.bay.still_since_s < spoken_s + STAND_WITHIN_S


def test_after_a_reset_by_the_port_nothing_is_restored(speaker: Speaker) -> None:
    speaker.set(1, DRIVEN, HELD)
    speaker.wait(0.1)

    speaker.bay.open(speaker.now_s)
    speaker.wait(0.2)

    assert speaker.bay.counts == [0] * 18


def test_nothing_is_let_go_of_after_a_restart_of_which_it_is_not_known_why(
    speaker: Speaker,
) -> None:
    for number in range(3):
        speaker.set(number, DRIVEN, HELD)
        speaker.wait(0.1)
        assert speaker.bay.counts == DRIVEN
        speaker.bay.controller.does("jump")
        speaker.wait(0.2)
        assert speaker.bay.counts == STOPPED
        speaker.send(0)
        speaker.wait(0.4)
    assert any("held slots were left alone" in line for line in speaker.words)


@pytest.mark.parametrize(
    ("hang", "says"),
    [("hang", "the watchdog restarted it"), ("deaf", "held slots were left alone")],
)
def test_nothing_is_let_go_of_after_a_hang_behind_a_boot_loader_that_clears_the_flags(
    speaker: Speaker, hang: str, says: str
) -> None:
    """A hang with interrupts switched off leaves no mark either."""
    speaker.bay.controller.does("loader")
    for number in range(3):
        speaker.set(number, DRIVEN, HELD)
        speaker.wait(0.1)
        assert speaker.bay.counts == DRIVEN
        speaker.bay.controller.does(hang)
        speaker.wait(0.4)
        assert speaker.bay.counts == STOPPED
        speaker.send(0)
        speaker.wait(0.4)
    assert any(says in line for line in speaker.words)


def test_nor_after_a_loss_of_power(speaker: Speaker) -> None:
    speaker.set(1, DRIVEN, HELD)
    speaker.wait(0.1)

    speaker.bay.controller.does("power")
    speaker.wait(0.2)

    assert speaker.bay.counts == [0] * 18


def test_a_board_that_never_answers_holds_up_no_other_and_is_named(speaker: Speaker) -> None:
    speaker.bay.dead.add(25)
    for number in range(20):
        speaker.set(number, DRIVEN, HELD)
        speaker.wait(0.1)
    assert speaker.bay.counts == DRIVEN
    assert len(speaker.on(126)) == 20
    assert "no answer from board 25" in speaker.words


def test_it_publishes_every_cycle_and_echoes_within_a_few(speaker: Speaker) -> None:
    speaker.frames.clear()
    written_s = []
    for number in range(20):
        written_s.append(speaker.now_s)
        speaker.set(number, DRIVEN, HELD)
        speaker.wait(0.1)

    assert 2.0 / 0.016 - 2 <= len(speaker.on(125)) <= 2.0 / 0.016 + 2
    echoes_s = [at_s for at_s, frame in speaker.frames if frame.topic == 126]
    assert all(0 < echo - at <= 0.07 for at, echo in zip(written_s, echoes_s, strict=True))


# --- the doctor, and the contract of every backend ------------------------------------------------


def patient() -> LinkPlan:
    """The plan of the shipped robot, had it a dead man's switch that waits for longer."""
    profile, plan = of(SIX_WHEELED)
    plan = plan._replace(serial=plan.serial.model_copy(update={"stop_after": 0.6}))
    return plan._replace(tables=tables_of(profile, plan))


def test_the_doctor_says_go(six_wheeled: Built) -> None:
    facts = examined(six_wheeled, loaded_mission())

    assert facts.go
    assert not [each for each in facts.findings if each.level != "note"]
    assert f"firmware 1 of {tables_of(*of(SIX_WHEELED))}" in [text for _, text in facts.words]


def test_the_doctor_refuses_a_robot_whose_tables_differ(six_wheeled: Built) -> None:
    facts = examined(six_wheeled, loaded_mission(), plan=patient())

    assert not facts.go
    assert any("then build and flash it" in each.message for each in facts.findings)


def test_a_run_with_other_tables_is_refused_before_anything_is_written(six_wheeled: Built) -> None:
    profile, plan = of(SIX_WHEELED)
    bay = AvrBay(six_wheeled, profile, SIX_WHEELED, loaded_mission().pipe)
    port = VirtualPort(bay, plan.serial.heartbeat_within)

    with pytest.raises(BackendError, match="then build and flash it"):
        SerialBackend(patient(), port).open()

    written = Decoder().feed(b"".join(data for _, data in port.written))
    assert {frame.topic for frame in written} <= {REQUEST_TOPICS, TIME, TX_STOP}


def test_the_doctor_names_a_board_that_does_not_answer(six_wheeled: Built) -> None:
    facts = examined(six_wheeled, loaded_mission(), dead=25)

    assert not facts.go
    assert "no answer from board 25" in [text for _, text in facts.words]


class TestContract(BackendContract):
    @pytest.fixture
    def candidate(self, newt: Built) -> Candidate:
        profile, plan = of(NEWT)
        pipe = load_pipe(NEWT / "elbow.yaml")[0]

        def make(seed: int) -> Backend:
            bay = AvrBay(newt, profile, NEWT, pipe, seed=seed, physics=World)
            return SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))

        return candidate(make, lambda backend: backend.port.device.robot.truth.wheels)
