"""Missions on the binary, and what may go wrong in them."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.arrays import loaded_mission
from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import LoadedMission
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Asked, detecting
from pirate_sm.running.runtime.backend_links import Holder
from pirate_sm.running.runtime.ending import Result
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.simulation.bay.virtual import VirtualPort

from .avr_bay import AvrBay, Built, Noise

STAND_WITHIN_S = 0.6
"""In this time wheels stand, whatever dies [issue: 600 ms; the switch takes 500 ms of them]."""


class Ride:
    """A mission on the binary, which is the bend if none is given."""

    def __init__(
        self, built: Built, seed: int = 1, noise: float = 0.0, loaded: LoadedMission | None = None
    ) -> None:
        self.loaded = loaded = loaded or loaded_mission()
        robot = loaded.loaded_robot
        self.bay = AvrBay(
            *(built, robot.profile, robot.folder, loaded.pipe),
            seed=seed,
            start_values=start_values(loaded),
            towards=Noise(noise, noise, seed),
            back=Noise(noise, noise, seed + 1),
            bus=Noise(noise, noise, seed + 2),
        )
        plan = read_plan(robot.folder, robot.profile, loaded.robot)
        self.port = Saboteur(self.bay, plan.serial.heartbeat_within)
        self.backend = SerialBackend(plan, self.port)

    def run(self) -> Result:
        loaded = self.loaded
        asked = Asked(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
        companions = (
            Holder(self.backend.hold),
            *detecting(None, "odometry", asked).companions,
            FirstChoice(),
        )
        engine = Engine(loaded.robot, loaded.program, nominal=False)
        return MissionRun(engine, self.backend, companions=companions).execute()


class KilledError(BaseException):
    """The program has ended without a chance to do anything."""


class Saboteur(VirtualPort):
    """Does something when wheels have been driven for a second.

    Attributes:
        sabotage: What is done.
        at_s: When it was done.
        held: What the other slots had in force then.
    """

    def __init__(self, bay: AvrBay, silence_s: float) -> None:
        super().__init__(bay, silence_s)
        self.bay = bay
        self.sabotage: Callable[[], object] | None = None
        self.at_s = 0.0
        self.held: dict[int, int] = {}
        self._driven_s = 0.0

    def write(self, data: bytes) -> None:
        now = self.now()
        if self.bay.still_since_s <= now:
            self._driven_s = now
        elif self.sabotage is not None and now > self._driven_s + 1.0:
            counts = enumerate(self.bay.counts)
            self.held = {at: count for at, count in counts if at not in self.bay.wheels}
            self.at_s, sabotage, self.sabotage = now, self.sabotage, None
            sabotage()
        super().write(data)

    def unplug(self) -> None:
        self.plugged = False

    def kill(self, guardian: bool) -> None:
        if guardian:
            self.die(self.at_s + 2.0)
        else:
            self.abandon()
            self.bay.advance(self.at_s + 2.0)
        raise KilledError
