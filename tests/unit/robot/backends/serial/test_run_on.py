"""How far a joint turns on when the cable goes while it bends: by the emulated bay's truth."""

from __future__ import annotations

from math import degrees, radians

import pytest

from benchmarks.arrays import bay_of, loaded_mission
from pirate_sm.core.engine import Engine
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Asked, detecting
from pirate_sm.running.runtime.backend_links import Holder
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

JOINT = 1
"""Place of the joint at wheel 2 among the truth's angles."""

AFTER_S = 6.0


class CutPort(VirtualPort):
    """Loses its cable when the joint has bent so far; the bay goes on."""

    def __init__(self, bay: VirtualBay, at_rad: float) -> None:
        super().__init__(bay)
        self._at_rad = at_rad
        self.cut_s = -1.0
        self.then: tuple[float, ...] = ()

    def write(self, data: bytes) -> None:
        super().write(data)
        bends, duties = self.device.truth.bends_rad, self.device.duties
        # A clamp turns this joint to the negative side; a bend brings it back from there.
        if self.plugged and duties[JOINT] > 0 and bends[JOINT] > self._at_rad:
            self.plugged, self.cut_s, self.then = False, self.now(), bends


def run_on(switch: bool) -> tuple[float, VirtualBay]:
    """Degrees that the joint has turned since the cable was cut, and the bay afterwards."""
    loaded = loaded_mission()
    bay, plan = bay_of(1, Switches(dead_man=switch))
    port = CutPort(bay, radians(-70))
    backend = SerialBackend(plan, port)
    holder = Holder(backend.hold)
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    asked = Asked(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
    detector = detecting(None, "odometry", asked)
    companions = (holder, *detector.companions, FirstChoice())
    result = MissionRun(engine, backend, companions=companions).execute()
    assert result.ended.message.startswith("link.lost")
    assert port.now() > port.cut_s + AFTER_S
    return degrees(abs(bay.truth.bends_rad[JOINT] - port.then[JOINT])), bay


@pytest.fixture(scope="module")
def with_switch() -> tuple[float, VirtualBay]:
    return run_on(switch=True)


def test_with_the_switch_a_joint_stops_within_its_time_and_speed(
    with_switch: tuple[float, VirtualBay],
) -> None:
    turned_deg, _ = with_switch

    assert turned_deg < 16, "half a second at 0.5 rad/s is 14 degrees"


def test_the_switch_keeps_the_clamps_and_stops_the_rest(
    with_switch: tuple[float, VirtualBay],
) -> None:
    _, bay = with_switch
    profile = loaded_mission().loaded_robot.profile
    left = bay.last_applied
    assert left is not None
    driven = {s.name for s, n in zip(profile.slots, left.counts, strict=True) if n and s.motor}

    assert {"bend_3", "bend_4"} <= driven
    assert not {"bend_1", "bend_2"} & driven
    assert not any(name.startswith("wheel") for name in driven)


def test_without_it_the_joint_goes_on_until_something_stops_it() -> None:
    turned_deg, _ = run_on(switch=False)

    assert turned_deg > 40
