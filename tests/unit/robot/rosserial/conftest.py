"""The link of a robot as its profile and its texts say it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Serial
from pirate_sm.robot.rosserial.messages import Messages, read_messages, serial_of

SIX_WHEELED = Path(__file__).resolve().parents[4] / "hardware_profiles" / "pirate_ii"


@pytest.fixture(scope="session")
def serial() -> Serial:
    return serial_of(load_robot(SIX_WHEELED).profile)


@pytest.fixture(scope="session")
def messages(serial: Serial) -> Messages:
    return read_messages(SIX_WHEELED / serial.messages, serial, 18)
