"""The backends that the suite holds to the protocol; `CANDIDATES` takes one more entry for each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from pathlib import Path
from typing import Any

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import Event, SubmitResult
from pirate_sm.core.loading import load_mission, load_pipe, load_robot
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.trace import TraceBackend
from pirate_sm.simulation.backend import SimulatorBackend
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort
from pirate_sm.simulation.kinematic.world import World, kinematic
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.testing import Candidate

from .obedient import ObedientPhysics

NEWT = Path(__file__).resolve().parents[1] / "robots" / "newt"

STILL = (0.0,) * 7
CLAMPING = (0.0, 0.0, -0.5, 0.0, 0.5, 0.0, 0.0)


TAKE_HOLD = load_mission(NEWT / "take_hold.yaml", pipe=str(NEWT / "elbow.yaml"))


class LateBackend:
    """A stand-in for a wire: what happens on it comes late, and every third echo is lost."""

    name = "late"
    completion = "nominal"
    real_time = False

    def __init__(self, delay_s: float = 0.3, unknown_s: float = 0.8, lose_every: int = 3) -> None:
        self._delay_s, self._unknown_s, self._lose_every = delay_s, unknown_s, lose_every
        self._now_s = 0.0
        self._sent = 0
        self._due: list[tuple[float, SubmitResult]] = []
        self._closed = False

    def open(self) -> Sequence[Event]:
        return ()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        if self._closed:
            raise BackendError("closed")
        self._sent += 1
        lost = self._sent % self._lose_every == 0
        wait_s = self._unknown_s if lost else self._delay_s
        status = "unknown" if lost else "accepted"
        self._due.append((self._now_s + wait_s, SubmitResult(setpoint_id, status, "")))

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        due_s = min((at for at, _ in self._due), default=inf)
        if min(due_s, until_s) == inf:
            raise BackendError("nothing will ever happen")
        self._now_s = max(self._now_s, min(due_s, until_s))
        events = [result for at, result in self._due if at <= self._now_s]
        self._due = [(at, result) for at, result in self._due if at > self._now_s]
        return self._now_s, events

    def close(self) -> None:
        self._closed = True


def _simulator(seed: int, physics: MakePhysics = World) -> Backend:
    pipe, _ = load_pipe(NEWT / "elbow.yaml")
    return SimulatorBackend(load_robot(NEWT).profile, pipe, seed=seed, physics=physics)


def _round(seed: int, physics: MakePhysics) -> Backend:
    pipe, _ = load_pipe(NEWT / "round.yaml")
    return SimulatorBackend(load_robot(NEWT).profile, pipe, seed=seed, physics=physics)


def _serial(seed: int, physics: MakePhysics = World) -> Backend:
    pipe, _ = load_pipe(NEWT / "elbow.yaml")
    robot = load_robot(NEWT)
    texts = message_texts(NEWT, robot.profile)
    bay = VirtualBay(robot.profile, pipe, texts, seed=seed, physics=physics)
    plan = read_plan(NEWT, robot.profile, robot.normal)
    return SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))


def candidate(
    make: Callable[[int], Backend],
    places: Callable[[Any], Sequence[tuple[float, float]]] = lambda backend: (),
) -> Candidate:
    """A backend of the small robot, and where its robot is (empty: nowhere)."""
    return Candidate(make, STILL, CLAMPING, TAKE_HOLD, places)


def _simulated_places(backend: Any) -> Sequence[tuple[float, float]]:
    return backend.truth.wheels  # type: ignore[no-any-return]


def _places_behind_the_port(backend: Any) -> Sequence[tuple[float, float]]:
    return backend.port.device.truth.wheels  # type: ignore[no-any-return]


CANDIDATES = {
    "trace": candidate(lambda seed: TraceBackend()),
    "sim": candidate(_simulator, _simulated_places),
    "sim, round": candidate(lambda seed: _round(seed, kinematic), _simulated_places),
    "physics": candidate(lambda seed: _simulator(seed, MujocoWorld), _simulated_places),
    "physics, round": candidate(lambda seed: _round(seed, MujocoWorld), _simulated_places),
    "sim, obedient": candidate(lambda seed: _simulator(seed, ObedientPhysics), _simulated_places),
    "serial": candidate(_serial, _places_behind_the_port),
    "serial, obedient": candidate(
        lambda seed: _serial(seed, ObedientPhysics), _places_behind_the_port
    ),
    "late": candidate(lambda seed: LateBackend()),
}
