"""How many frames the simulator takes for the engine, and what that saves.

    python -m benchmarks.gliding [MISSION ...] [--repeats 9]

Each mission is run with every frame through the engine and without, in turn, and the least process
time of each counts, so that other work on the machine falls on both alike.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import cache
from math import inf
from time import process_time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pirate_sm.core.events import Event
    from pirate_sm.core.loading import LoadedMission
    from pirate_sm.core.sensing import Glide
    from pirate_sm.robot.backends.protocol import Backend, Completion
    from pirate_sm.running.wiring import Order

REPEATS = 9
MISSIONS = (
    *("mitre_bend", "take_bend", "climb", "enter_3d", "exp_1_round", "exp_1a_both"),
    *("take_elbow", "take_branch", "two_bends_up", "house_connection", "level"),
)


class Stepping:
    """A backend that cannot glide, so that every frame goes through the engine."""

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self.name, self.real_time = backend.name, backend.real_time
        self.completion: Completion = backend.completion

    def open(self) -> Sequence[Event]:
        """As the backend."""
        return self._backend.open()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """As the backend."""
        self._backend.submit(setpoint_id, values)

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """As the backend."""
        return self._backend.advance(until_s)

    def close(self) -> None:
        """As the backend."""
        self._backend.close()


class Taken:
    """Counts the frames that a simulator takes for the engine."""

    def __init__(self, backend: Backend) -> None:
        self.frames = 0
        self._glide = backend.glide  # type: ignore[attr-defined]
        backend.glide = self._count  # type: ignore[attr-defined]

    def _count(self, *given: object) -> Glide | None:
        passed: Glide | None = self._glide(*given)
        self.frames += len(passed.frames) if passed is not None else 0
        return passed


class Frames:
    """Counts the frames of a run, as a tap."""

    stepwise, due_s = False, inf

    def __init__(self) -> None:
        self.count = 0

    def start(self, *given: object, **named: object) -> None:
        """Count nothing."""

    def take_glide(self, passed: Glide) -> None:
        """Count nothing: the backend of this run cannot glide."""

    def take(self, event: Event, now_s: float, effects: object) -> None:
        """Count a frame."""
        self.count += type(event).__name__ == "SensorFrame"

    def secure(self) -> None:
        """Keep nothing."""

    def abandon(self, now_s: float, effects: object) -> None:
        """Count nothing."""


@cache
def _loaded(order: str) -> LoadedMission:
    from pirate_sm.running.wiring import Order, load

    return load(Order(order))


def run(order: Order, *, glides: bool, counts: bool = False) -> tuple[float, float, int, int]:
    """Return process time, mission time, frames taken, and frames that went through the engine."""
    from pirate_sm.core.companion import entered
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.running.runtime.scripted_events import FirstChoice
    from pirate_sm.running.wiring import prepare

    loaded = _loaded(order.mission)
    began = process_time()
    prepared = prepare(order, loaded)
    backend = prepared.backend if glides else Stepping(prepared.backend)
    taken = Taken(prepared.backend) if counts else None
    frames = Frames() if counts and not glides else None
    companions = (*prepared.companions, FirstChoice())
    mission = MissionRun(prepared.engine, backend, companions=companions, tap=frames)
    with entered(prepared.companions):
        result = mission.execute()
    took_s = process_time() - began
    return took_s, result.now_s, taken.frames if taken else 0, frames.count if frames else 0


def main() -> int:
    """Every mission is measured with each detector and printed."""
    from pirate_sm.running.wiring import Order

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("missions", nargs="*", metavar="MISSION", default=MISSIONS)
    parser.add_argument("--repeats", type=int, default=REPEATS)
    wishes = parser.parse_args()
    for mission in wishes.missions:
        for detector in ("sim", "odometry"):
            order = Order(mission, detector=detector)
            _, _, taken, _ = run(order, glides=True, counts=True)
            *_, frames = run(order, glides=False, counts=True)
            times = [
                (run(order, glides=True), run(order, glides=False)) for _ in range(wishes.repeats)
            ]
            glided_s = min(glided[0] for glided, _ in times)
            stepped_s = min(stepped[0] for _, stepped in times)
            mission_s = times[0][0][1]
            print(
                f"{mission:22} {detector:9} {taken:5} of {frames:5} frames taken, "
                f"{mission_s / stepped_s:5.0f} × real time stepped, {mission_s / glided_s:5.0f} "
                f"gliding: {stepped_s / glided_s:.2f} × faster"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
