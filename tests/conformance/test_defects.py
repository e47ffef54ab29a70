"""A defect of the robot leads to the same faults and the same end, whatever the robot is behind.

Every defect of the profile is switched on with equal seeds in the simulator and behind the
emulated bay, in virtual time. Times differ, for the bay boots and its line takes time; so a
defect that comes and goes at random is tried with its own seeds only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from representative import thorough_but

from pirate_sm.core.effects import Effect, Fault
from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import LoadedMission, load_mission, load_robot
from pirate_sm.core.models import Defect
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.simulation.backend import SimulatorBackend
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

ROOT = Path(__file__).resolve().parents[2]
SIX_WHEELED = ROOT / "hardware_profiles" / "pirate_ii"

MISSION = """
format: 1
mission: there_and_back
robot: pirate_ii
pipe: {diameter: 120 mm, segments: [{straight: 3 m}], start: {at: 1 m}}
on_fault: [{fault: [sensor.spiking, sensor.jumped], then: continue}]
start: there
phases:
  there:
    do: [ClampFront, ClampRear, DriveForward]
    wait: [{when: odometry >= 0.4 m, go: regrip}]
    within: {time: 20 s, go: late}
  regrip:
    do: [Brake, RelaxFront, BendInto, ClampFront, DriveBackward]
    wait: [{when: odometry <= 0.2 m, go: back}]
    within: {time: 20 s, go: late}
ends:
  back: {succeed: Back}
  late: {fail: Too late}
"""


# Of the controller of the link, which the profile's own defects leave alone.
OF_THE_CONTROLLER = {
    "restarts": Defect(kind="controller_reset", description="", after=12.0, lasting=2.0),
    "hangs_briefly": Defect(kind="controller_hang", description="", after=12.0, lasting=0.1),
    "hangs_for_good": Defect(kind="controller_hang", description="", after=12.0),
    "moves_a_motor": Defect(kind="stray_motion", description="", after=12.0),
}


CLOSING = "gamma_2_sticks_at_zero"
"""At its own 5 s the joint closes: which faults it raises depends on how far it has come."""

DEFECTS = [each for each in load_robot(SIX_WHEELED).profile.simulation.defects if each != CLOSING]
TIMED = [
    "wheel_1_dead:after=6s",
    "gamma_1_stiff:friction=0.5Nm,after=12s",
    "board_26_silent:after=13s",
    "gamma_1_zero_jumps:by=-25deg,after=12s",
    f"{CLOSING}:after=1s",
    f"{CLOSING}:after=14s",
]
"""Defects that begin in the middle of the mission."""

FEW = [
    *("gamma_2_drops", "gamma_3_spikes", "imu_stale", "messages_lost"),
    *("firmware_reset", "wheels_3_4_dead", "moves_a_motor", TIMED[2]),
]
"""Of each kind one."""


class Course(NamedTuple):
    """How a mission went."""

    outcome: str
    end: str
    faults: frozenset[str]


class Faults:
    """Keeps the codes of the faults up to the one that ends the mission."""

    def __init__(self) -> None:
        self.codes: set[str] = set()
        self._over = False

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        for effect in effects:
            if isinstance(effect, Fault) and not self._over:
                self.codes.add(effect.code)
                self._over = effect.handling == "stop"


def in_the_simulator(loaded: LoadedMission, defect: str, seed: int) -> Backend:
    assert loaded.pipe is not None
    profile = loaded.loaded_robot.profile
    return SimulatorBackend(profile, loaded.pipe, seed=seed, defects=(defect,))


def behind_the_bay(loaded: LoadedMission, defect: str, seed: int) -> Backend:
    assert loaded.pipe is not None
    robot = loaded.loaded_robot
    texts = message_texts(robot.folder, robot.profile)
    bay = VirtualBay(robot.profile, loaded.pipe, texts, Switches(defects=(defect,)), seed)
    plan = read_plan(robot.folder, robot.profile, loaded.robot)
    return SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))


@cache
def loaded_in(folder: Path) -> LoadedMission:
    file = folder / "there_and_back.yaml"
    file.write_text(MISSION, encoding="utf-8")
    loaded = load_mission(file)
    robot = loaded.loaded_robot
    defects = {**robot.profile.simulation.defects, **OF_THE_CONTROLLER}
    simulation = robot.profile.simulation.model_copy(update={"defects": defects})
    profile = robot.profile.model_copy(update={"simulation": simulation})
    return replace(loaded, loaded_robot=replace(robot, profile=profile))


def course(loaded: LoadedMission, backend: Backend) -> Course:
    faults = Faults()
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    ended = MissionRun(engine, backend, observers=[faults]).execute().ended
    return Course(ended.outcome, ended.end, frozenset(faults.codes))


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedMission:
    return loaded_in(tmp_path_factory.mktemp("missions"))


@pytest.mark.parametrize("seed", thorough_but([1], [1, 2]))
@pytest.mark.parametrize("defect", thorough_but(FEW, [*DEFECTS, *OF_THE_CONTROLLER, *TIMED]))
def test_a_defect_has_the_same_consequences_in_the_simulator_and_behind_the_bay(
    loaded: LoadedMission, defect: str, seed: int
) -> None:
    simulated = course(loaded, in_the_simulator(loaded, defect, seed))
    emulated = course(loaded, behind_the_bay(loaded, defect, seed))

    assert simulated == emulated


@pytest.mark.thorough
@pytest.mark.parametrize("after", ["2s", "3s", "5s"])
def test_a_joint_that_sticks_while_it_closes_stops_the_mission_wherever_it_is(
    loaded: LoadedMission, after: str
) -> None:
    for behind in (in_the_simulator, behind_the_bay):
        found = course(loaded, behind(loaded, f"{CLOSING}:after={after}", 1))
        assert found.outcome in ("failed", "fault")
        assert found.faults
        assert found.faults <= {"sensor.jumped", "sensor.stuck"}
