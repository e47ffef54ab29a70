"""The plans of two robots, ready to be spoken to."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.loading import load_robot
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan, plan_of
from pirate_sm.robot.rosserial.messages import read_messages, serial_of

from .device import Device, VirtualPort

ROOT = Path(__file__).resolve().parents[5]
SIX_WHEELED = ROOT / "hardware_profiles" / "pirate_ii"


def without_refresh(plan: LinkPlan) -> LinkPlan:
    """The same robot, and nothing is written to it without a reason of its own."""
    never = {"refresh_every": None, "stop_after": None}
    return plan._replace(serial=plan.serial.model_copy(update=never))


@pytest.fixture(scope="session")
def plan() -> LinkPlan:
    robot = load_robot(SIX_WHEELED)
    serial = serial_of(robot.profile)
    messages = read_messages(SIX_WHEELED / serial.messages, serial, len(robot.profile.slots))
    return plan_of(robot.profile, robot.normal, messages)


@pytest.fixture
def device(plan: LinkPlan) -> Device:
    return Device(plan)


@pytest.fixture
def port(device: Device) -> VirtualPort:
    return VirtualPort(device)
