"""Bays of the shipped robot, and a host that is nobody's driver: just enough to ask and listen."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from pirate_sm.core.documents import read_document
from pirate_sm.core.loading import validate
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.robot.rosserial.frames import encode
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay

ROOT = Path(__file__).resolve().parents[4]
FOLDER = ROOT / "hardware_profiles" / "pirate_ii"
BAUD_BYTES_PER_S = 5760.0
STATE, ECHO, SETPOINTS = 125, 126, 100
SLOTS = 18

MakeBay = Callable[..., "Host"]


class Heard(NamedTuple):
    at_s: float
    topic: int
    payload: bytes


def array(number: int, *values: int, slots: int = SLOTS) -> bytes:
    padded = (*values, *(0,) * (slots - len(values)))
    return struct.pack(f"<I{slots}h", number, *padded)


def read_array(payload: bytes) -> tuple[int, tuple[int, ...]]:
    number, *values = struct.unpack(f"<I{(len(payload) - 4) // 2}h", payload)
    return number, tuple(values)


def read_state(payload: bytes) -> tuple[int, tuple[float, ...]]:
    board, *values = struct.unpack("<B9f", payload)
    return board, tuple(values)


class Host:
    """Sends whole frames and cuts what comes back into frames, looking every millisecond."""

    step_s = 0.001

    def __init__(self, bay: VirtualBay) -> None:
        self.bay = bay
        self.now_s = 0.0
        self.heard: list[Heard] = []
        self.raw = b""
        self.answers_time = True
        self._waiting = b""

    def open(self) -> None:
        self.bay.open(self.now_s)

    def send(self, topic: int, payload: bytes = b"") -> None:
        self.bay.receive(encode(topic, payload), self.now_s)

    def listen(self, seconds: float) -> list[Heard]:
        """What came in this time."""
        before = len(self.heard)
        for _ in range(round(seconds / self.step_s)):
            self.now_s += self.step_s
            self.take(self.bay.advance(self.now_s))
        return self.heard[before:]

    def take(self, data: bytes) -> list[Heard]:
        """The frames that these bytes complete."""
        before = len(self.heard)
        self.raw += data
        self._waiting += data
        self._cut()
        return self.heard[before:]

    def _cut(self) -> None:
        while len(self._waiting) >= 8:
            length = int.from_bytes(self._waiting[2:4], "little")
            whole = self._waiting[: 8 + length]
            if self._waiting[:2] == b"\xff\xfe" and length < 1000 and len(whole) < 8 + length:
                return
            topic = int.from_bytes(whole[5:7], "little")
            if encode(topic, whole[7:-1]) != whole:
                self._waiting = self._waiting[1:]
                continue
            self._waiting = self._waiting[len(whole) :]
            self.heard.append(Heard(self.now_s, topic, whole[7:-1]))
            if topic == 10 and self.answers_time:
                self.send(10, struct.pack("<II", 1, 2))

    def connect(self) -> None:
        """The bay is up and configured."""
        self.open()
        self.listen(2.1)
        self.send(0)
        self.listen(0.3)
        assert self.bay.configured

    def events(self, kind: str) -> list[Any]:
        return [record for record in self.bay.records if record.event == kind]


def read_profile(path: Path) -> Profile:
    return validate(read_document(path), Profile)


@pytest.fixture(scope="session")
def profile() -> Profile:
    return read_profile(FOLDER / "profile.yaml")


@pytest.fixture(scope="session")
def texts(profile: Profile) -> dict[str, str]:
    return message_texts(FOLDER, profile)


@pytest.fixture(scope="session")
def pipe() -> Pipe:
    return validate(read_document(ROOT / "sequences" / "pipes" / "mitre_90.yaml"), Pipe)


@pytest.fixture
def make(profile: Profile, texts: dict[str, str], pipe: Pipe) -> MakeBay:
    def made(seed: int = 1, **switches: Any) -> Host:
        # These hosts send an array once and look at what follows from it: see test_dead_man.py.
        chosen = Switches(**{"dead_man": False, **switches})
        return Host(VirtualBay(profile, pipe, texts, chosen, seed))

    return made


@pytest.fixture
def host(make: MakeBay) -> Host:
    """Connected to a bay with which nothing is wrong."""
    host = make()
    host.connect()
    return host
