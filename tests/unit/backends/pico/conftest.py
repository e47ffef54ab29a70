"""The plans of two robots, ready to be spoken to."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.backends.pico.messages import read_messages
from pirate_sm.backends.pico.plan import Plan, plan_of, serial_of
from pirate_sm.loading.robot import load_robot

ROOT = Path(__file__).resolve().parents[4]
SIX_WHEELED = ROOT / "hardware_profiles" / "pirate_ii"


@pytest.fixture(scope="session")
def plan() -> Plan:
    robot = load_robot(SIX_WHEELED)
    serial = serial_of(robot.profile)
    messages = read_messages(SIX_WHEELED / serial.messages, serial, len(robot.profile.slots))
    return plan_of(robot.profile, robot.normal, messages)
