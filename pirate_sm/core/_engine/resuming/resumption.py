"""Put together with what a mission is started that goes on after a crash."""

from __future__ import annotations

from math import nan
from typing import NamedTuple

from pirate_sm.core._engine.mission.program import HERE, Program
from pirate_sm.core._engine.resuming.dark_way import DarkWay, odometry_m
from pirate_sm.core._engine.resuming.entry import Entry, Refused, entry, resumed_program
from pirate_sm.core._engine.resuming.hypotheses import Hypothesis
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.sensing.known_signals import DistanceMemory
from pirate_sm.core._engine.state import Counted, EngineState


class Resumption(NamedTuple):
    """With what a mission goes on; ``Engine.start`` takes it, with :attr:`program` as its program.

    All of it is plain data that a recording can hold as text; :func:`.entry.resumed_program` makes
    the program again from the entry and the program of the run before.

    Attributes:
        entry: Where it goes on.
        body: The robot at rest, with nothing confirmed; its values are those of the first array.
        clock_s: Mission time at which the run was cut off, which goes on from there.
        cause: Reason of the last failure or fault; ``handling``: the phase that handles a fault.
        paused: Whether the operator had paused the mission.
        rules: Progress of the safety rules.
        odometry_m: Odometry at the start; NaN if the robot has none.
        adrift: Whether that is not known, so that conditions see only its changes from now on.
        distance: What is remembered to judge the odometry.
        counts_from: See :class:`.MissionState`, likewise ``claim``.
    """

    entry: Entry
    body: RobotState
    clock_s: float = 0.0
    cause: str = ""
    handling: str = ""
    paused: bool = False
    rules: tuple[int, ...] = ()
    odometry_m: float = nan
    adrift: bool = False
    distance: DistanceMemory = DistanceMemory()
    counts_from: Counted = Counted()
    claim: Counted | None = None

    def program(self, before: Program) -> Program:
        """Return the program of the resumed run, from that of the run before."""
        return resumed_program(before, self.entry)


class Beginning(NamedTuple):
    """How a mission begins where that is not as it is declared; see ``Engine.start``."""

    body: RobotState | None = None
    paused: bool = False
    resumed: Resumption | None = None


AS_DECLARED = Beginning()


def resumption(
    robot: RobotSpec,
    program: Program,
    last: EngineState,
    last_s: float,
    hypothesis: Hypothesis,
    way: DarkWay,
    at: str = HERE,
) -> Resumption | Refused:
    """Return with what the mission goes on, or why it cannot.

    Args:
        robot: The robot.
        program: The program that was recorded.
        last: The engine's last recorded state.
        last_s: When that was, s.
        hypothesis: Where the robot is taken to be.
        way: How far it has driven since, as its wheels show or a person says.
        at: Where to go on: ``here``, ``failure`` or a phase, see :func:`.entry.entry`.
    """
    lost = {wheel.angle for wheel in robot.wheels} - way.seen
    if not way.exact:
        lost.add(robot.odometry)
    found = entry(robot, program, last, last_s, hypothesis.body, at, lost=lost)
    if isinstance(found, Refused):
        return found
    mission, distance = last.mission, last.sensing.distance
    return Resumption(
        found,
        hypothesis.body,
        mission.clock(last_s),
        mission.cause,
        mission.diverting.go_name if mission.diverting is not None else mission.handling,
        mission.paused or mission.pause_wanted,
        last.rules,
        odometry_m(robot, last.sensing, way),
        not way.exact and robot.odometry >= 0,
        distance._replace(width_m=distance.width_m + (way.high_m - way.low_m) / 2),
        mission.counts_from,
        mission.claim,
    )
