"""How well velocity and torque loops keep their targets over the emulated bay.

    python -m benchmarks.loops [--seeds 20] [--loss 20]

The mission `loops.yaml` clamps, takes the control exp_3a (90 mm/s, 350 mNm), and drives there and
back, over a line that loses nothing and over one that loses a share of all frames each way. Speeds
and torques are those that the boards report, from 1.5 s after the wheels have been driven. The mean
speed of each wheel must be within 2 mm/s of its target, the mean torque of each joint within
40 mNm.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from typing import NamedTuple

from benchmarks.arrays import bay_at
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.program import Wait
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.running.runtime.backend_links import Holder
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.virtual import VirtualPort

MISSION = Path(__file__).with_name("loops.yaml")
SPEED_M_S, WITHIN_M_S = 0.090, 0.002
TORQUES_NM, WITHIN_NM = (-0.350, 0.0, 0.0, 0.350), 0.040
SETTLED_S = 1.5


class Drive(NamedTuple):
    """What one run came to.

    Attributes:
        speed_m_s: The largest error of a wheel's mean speed, of all wheels and both directions.
        torque_nm: The largest error of a joint's mean torque.
        ended: How the mission ended.
    """

    speed_m_s: float
    torque_nm: float
    ended: str


class _Recorder:
    """Collects speeds and torques while the mission waits and the loops have settled."""

    def __init__(self, loaded: LoadedMission) -> None:
        self.speeds: dict[str, list[list[float]]] = {}
        self.torques: list[list[float]] = []
        self._loaded = loaded
        names = loaded.robot.vocabulary.numbers
        self._joints = [
            names.index(j.torque or "") for j in loaded.loaded_robot.profile.body.joints
        ]

    def look(self, state: EngineState, now_s: float) -> Sequence[Effect]:
        program, mission = self._loaded.program, state.mission
        waits = mission.begun and isinstance(program.instructions[mission.pc], Wait)
        if waits and mission.clock(now_s) - mission.armed_s > SETTLED_S:
            numbers = state.sensing.numbers
            rims = [numbers[w.speed] * w.metres_per_rad for w in self._loaded.robot.wheels]
            self.speeds.setdefault(program.phase_of[mission.pc], []).append(rims)
            self.torques.append([numbers[joint] for joint in self._joints])
        return ()


def drive(seed: int, loss: float) -> Drive:
    """Run the mission once over a line that loses this share of all frames each way."""
    loaded = load_mission(MISSION)
    bay, plan = bay_at(loaded, seed, Switches(loss, loss))
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    recorder, step = _Recorder(loaded), engine.step

    def recorded(state, event, now_s):  # type: ignore[no-untyped-def]
        after = step(state, event, now_s)
        recorder.look(after[0], now_s)
        return after

    engine.step = recorded  # type: ignore[method-assign]
    result = MissionRun(engine, backend, companions=(Holder(backend.hold), FirstChoice())).execute()
    if not recorder.torques:
        return Drive(float("nan"), float("nan"), result.ended.message)
    speed = max(
        abs(abs(fmean(wheel)) - SPEED_M_S)
        for rims in recorder.speeds.values()
        for wheel in zip(*rims, strict=True)
    )
    joints = zip(zip(*recorder.torques, strict=True), TORQUES_NM, strict=True)
    torque = max(abs(fmean(values) - target) for values, target in joints)
    return Drive(speed, torque, result.ended.outcome)


def main() -> int:
    """Print a line for each line quality; return 1 where a bar is not met."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--loss", type=float, default=20, help="in per cent, each way")
    options = parser.parse_args()
    good = True
    for loss in (0.0, options.loss / 100):
        drives = [drive(seed, loss) for seed in range(options.seeds)]
        done = sum(each.ended == "succeeded" for each in drives)
        speed = max(each.speed_m_s for each in drives)
        torque = max(each.torque_nm for each in drives)
        met = done == len(drives) and speed <= WITHIN_M_S and torque <= WITHIN_NM
        good = good and met
        print(
            f"loss {loss:4.0%}: {done} of {len(drives)} succeeded; largest error of a mean speed "
            f"{speed * 1000:.2f} mm/s (bar 2), of a mean torque {torque * 1000:.0f} mNm (bar 40)"
            f"{'' if met else '  NOT MET'}",
            flush=True,
        )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
