"""The URDF of a robot: a standard parser takes it, and it stands where the simulator stands."""

from __future__ import annotations

import warnings
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from pirate_sm.core._geometry.chain import ORIGIN, Chain
from pirate_sm.core.events import SensorFrame
from pirate_sm.core.loading import load_mission, load_robot
from pirate_sm.running.recording.viewers.transforms import link_poses
from pirate_sm.running.recording.viewers.urdf import urdf
from pirate_sm.simulation.backend import SimulatorBackend

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from urdf_parser_py.urdf import URDF

ROOT = Path(__file__).resolve().parents[5]
ROBOTS = {
    "pirate_ii": ROOT / "hardware_profiles" / "pirate_ii",
    "newt": ROOT / "tests" / "robots" / "newt",
}


@pytest.fixture(params=ROBOTS)
def profile(request):
    return load_robot(ROBOTS[request.param]).profile


def parsed(profile):
    return URDF.from_xml_string(urdf(profile).encode())


def wheels(body, angles, front=ORIGIN):
    """Where the wheels are, from the angles of the joints by name."""
    at = {joint.wheel: angles.get(joint.name, 0.0) for joint in body.joints}
    chain = Chain(tuple(link.length for link in body.links), ())
    return chain.places([at.get(wheel.name, 0.0) for wheel in body.wheels], 0, front)


def turn(axis, angle):
    """Rotation about a coordinate axis, by Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def forward(model, angles):
    """Where each link is, from the parsed file alone."""
    found = {model.get_root(): np.eye(4)}
    pending = list(model.joints)
    while pending:
        joint = pending.pop(0)
        if joint.parent not in found:
            pending.append(joint)
            continue
        step = np.eye(4)
        step[:3, 3] = joint.origin.xyz
        if joint.type != "fixed":
            step = step @ turn(joint.axis, angles.get(joint.name, 0.0))
        found[joint.child] = found[joint.parent] @ step
    return found


def test_a_standard_parser_finds_every_wheel_link_and_joint(profile):
    model = parsed(profile)

    names = {joint.name for joint in model.joints}
    assert {joint.name for joint in profile.body.joints} <= names
    assert {wheel.name for wheel in profile.body.wheels} <= {link.name for link in model.links}
    assert len(model.joints) == len(model.links) - 1, "a tree"


def test_its_mass_is_that_of_the_robot(profile):
    body = profile.body
    mass = sum(link.mass for link in body.links) + sum(wheel.mass for wheel in body.wheels)

    assert sum(link.inertial.mass for link in parsed(profile).links) == pytest.approx(mass)


def test_joints_have_the_limits_of_the_profile(profile):
    joints = {joint.name: joint for joint in parsed(profile).joints}

    for joint in profile.body.joints:
        assert joints[joint.name].limit.upper == pytest.approx(joint.end_stop)
        assert joints[joint.name].limit.lower == pytest.approx(-joint.end_stop)
        assert joints[joint.name].limit.effort > 0


def test_forward_kinematics_of_the_file_and_of_the_package_agree(profile):
    rng = np.random.default_rng(1)
    for _ in range(20):
        angles = {joint.name: rng.uniform(-2, 2) for joint in profile.body.joints}
        placed = forward(parsed(profile), angles)
        seen = [placed[wheel.name][:2, 3] for wheel in profile.body.wheels]

        assert np.allclose(seen, wheels(profile.body, angles), atol=1e-9)


def test_forward_kinematics_equal_the_simulators_through_the_bend():
    """Every joint angle that the simulator's sensors show puts the wheels where they really are."""
    loaded = load_mission(ROOT / "sequences" / "mitre_bend.yaml")
    profile, robot = loaded.loaded_robot.profile, loaded.robot
    backend = SimulatorBackend(profile, loaded.pipe, seed=1)
    angles: dict[str, float] = {}
    names = robot.vocabulary.numbers
    compared = 0
    events = list(backend.open())
    values = [0.0] * len(robot.slots)
    for slot, duty in {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.4, "bend_4": 0.9}.items():
        values[[each.name for each in robot.slots].index(slot)] = duty
    backend.submit(1, tuple(values))
    now = 0.0
    while now < 14.0:
        for event in events:
            if isinstance(event, SensorFrame):
                board = robot.boards[event.board]
                for place, target, scale in board.channels:
                    angles[names[target]] = event.values[place] * scale
        if now > 13.0:  # the joints stand still: boards report one after the other
            real = np.array(backend.truth.wheels)
            front = link_poses(backend.truth.wheels)[0]
            seen = np.array(wheels(profile.body, angles, front))
            # A count of the sensor is 0.09 deg, its noise 0.05 deg.
            assert np.abs(seen - real).max() < 4e-3
            compared += 1
        now, events = backend.advance(now + 0.05)
    assert compared > 10


def test_it_is_well_formed_xml(profile):
    assert Xml.fromstring(urdf(profile).partition("\n")[2]).tag == "robot"
