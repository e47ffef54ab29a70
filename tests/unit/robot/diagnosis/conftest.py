"""The shipped robot at an emulated bay, driven by one virtual clock."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core.errors import BackendError
from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.diagnosis.facts import ExpectedRobot
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay

ROOT = Path(__file__).resolve().parents[4]
FOLDER = ROOT / "hardware_profiles" / "pirate_ii"

Connect = Callable[..., Listening]


class BayPort:
    """A port with a bay behind it; time passes by reading."""

    name = "virtual"
    epoch_s = 1.7e9

    def __init__(self, bay: VirtualBay | None, answer: bytes = b"") -> None:
        self.bay = bay
        self.answer = answer
        self.now_s = 0.0
        self.is_open = False
        self.refuses = ""

    def now(self) -> float:
        return self.now_s

    def open(self) -> None:
        if self.refuses:
            raise BackendError(self.refuses)
        self.is_open = True
        if self.bay is not None:
            self.bay.open(self.now_s)

    def reopen(self) -> bool:
        return True

    def write(self, data: bytes) -> None:
        if self.bay is not None:
            self.bay.receive(data, self.now_s)

    def read(self, until_s: float) -> bytes:
        if self.bay is None:
            self.now_s = max(self.now_s, until_s)
            return self.answer
        while True:
            data = self.bay.advance(self.now_s)
            if data or self.now_s >= until_s:
                return data
            self.now_s = min(until_s, max(self.now_s + 1e-6, self.bay.due_s))

    def wait(self, until_s: float) -> None:
        self.now_s = max(self.now_s, until_s)

    def beat(self, safe_frame: bytes) -> None:
        pass

    def overruled(self) -> bool:
        return False

    def remark(self) -> str:
        return ""

    def close(self, stopped: bool = False) -> None:
        self.is_open = False
        if self.bay is not None:
            self.now_s += 0.1  # what was written goes out
            self.bay.advance(self.now_s)
            self.bay.close(self.now_s)


@pytest.fixture(scope="session")
def subject() -> ExpectedRobot:
    loaded = load_robot(FOLDER)
    return ExpectedRobot(
        loaded.profile, loaded.normal, read_plan(FOLDER, loaded.profile, loaded.normal)
    )


@pytest.fixture
def connect(subject: ExpectedRobot) -> Connect:
    """A connection, not open yet, to a bay with these switches."""
    pipe = load_pipe(ROOT / "sequences" / "pipes" / "mitre_90.yaml")[0]
    texts = message_texts(FOLDER, subject.profile)

    def connected(check: Callable[[], None] = lambda: None, **switches: Any) -> Listening:
        bay = VirtualBay(subject.profile, pipe, texts, Switches(**switches), seed=3)
        return Listening(subject, BayPort(bay), subject.plan.serial.baud, check)

    return connected


def bay_of(listening: Listening) -> VirtualBay:
    assert isinstance(listening.port, BayPort)
    assert listening.port.bay is not None
    return listening.port.bay
