"""Missions on the emulated bay in virtual time that are cut off, resumed, and judged by its truth.

The recording holds what a real one would: what was written at intervals of 0.25 s and before each
command. What is killed, and when, is a case; equal cases give equal rides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cache
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from pirate_sm.core import library
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import PirateError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.robot import states_of
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Asked, Places, detecting
from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.runtime.backend_links import Holder
from pirate_sm.running.runtime.pump import Pump, Resuming
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, Prepared
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.running.wiring.resume_offer import EndOfRun, Said, end_of_run, offer, see
from pirate_sm.running.wiring.resumed_run import driven_s, with_resumption
from pirate_sm.running.wiring.run_recorder import RunRecorder, run_header
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

WRITTEN_EVERY_S = 0.25
"""Interval at which a recorder writes, s; see `recorder.COMMIT_S`."""

LOOSE_S = 0.3
"""A grip that is missing for longer is lost: a clamp that is pressed anew may be slack before."""

MOST_S = 900.0
"""No shipped mission takes longer."""

ALIVE = ("runner", "runner and guardian")
KINDS = (*ALIVE, "bay", "power")
"""What dies. In virtual time a bay that dies takes the run with it, and its guardian goes on."""


@dataclass(frozen=True)
class Case:
    """A mission that is cut off.

    Attributes:
        share: When, as a share of the time that it takes otherwise.
        dark_s: How long nobody records.
        lie: What is changed meanwhile, see ``LIES``; empty for nothing.
    """

    mission: str
    kind: str
    share: float
    dark_s: float
    seed: int = 0
    lie: str = ""


class Trace(NamedTuple):
    """What a run did: its configurations in order, and how it ended; empty if it did not.

    Attributes:
        loose: Phases in which no part gripped for ``LOOSE_S``.
    """

    configurations: tuple[tuple[str, ...], ...]
    outcome: str
    message: str
    until_s: float
    loose: frozenset[str]


class Ride(NamedTuple):
    """What came of a case.

    Attributes:
        how: ``success``, ``failure``, ``refused``, or ``let go``.
        asked: What a person had to agree to; empty if nothing.
        same: Whether it visited the same configurations and ended as the run left alone.
        phase: Where it was cut off.
    """

    case: Case
    how: str
    why: str = ""
    asked: tuple[str, ...] = ()
    same: bool = False
    phase: str = ""


class _Memory:
    """A file in memory."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: bytes, /) -> None:
        self.data += data

    def close(self) -> None:
        pass


def grips(loaded: LoadedMission, torques_nm: Sequence[float]) -> bool:
    """Return whether a part grips, by the torques of the joints at each wheel."""
    profile = loaded.loaded_robot.profile
    wheels = [wheel.name for wheel in profile.body.wheels]
    at = {joint.name: wheels.index(joint.wheel) for joint in profile.body.joints}
    least_nm = min(part.slack for part in profile.seen.parts.values())
    return any(abs(torques_nm[at[it.apex]]) >= least_nm for it in profile.body.parts.values())


class _Grip:
    """Watches by the bay's truth whether a part grips.

    Attributes:
        loose: Phases in which none did for ``LOOSE_S``.
        ever: Whether one ever did.
    """

    def __init__(self, loaded: LoadedMission, bay: VirtualBay) -> None:
        self._loaded = loaded
        self._bay = bay
        self._since_s = inf
        self.loose = set[str]()
        self.ever = False

    def look(self, now_s: float, phase: str) -> None:
        """Look at the robot."""
        if grips(self._loaded, self._bay.robot.values("bend_torque")):
            self.ever, self._since_s = True, inf
            return
        self._since_s = min(self._since_s, now_s)
        if self.ever and now_s >= self._since_s + LOOSE_S:
            self.loose.add(phase)


class World(NamedTuple):
    """A bay with a robot in it, switched on."""

    loaded: LoadedMission
    bay: VirtualBay
    port: VirtualPort


@cache
def loaded_mission(name: str) -> LoadedMission:
    """Return the shipped mission with this name."""
    return load_mission(library.find_mission(name))


@cache
def missions() -> tuple[str, ...]:
    """Return the shipped missions that a robot with a serial link can run in a pipe."""
    names = [path.stem for path in library.missions()]
    found = []
    for name in names:
        try:
            loaded = loaded_mission(name)
        except PirateError:
            continue
        if loaded.pipe is not None and loaded.loaded_robot.profile.serial is not None:
            found.append(name)
    return tuple(found)


def world(mission: str, seed: int) -> World:
    """Return a bay for this mission."""
    loaded = loaded_mission(mission)
    profile, folder = loaded.loaded_robot.profile, loaded.loaded_robot.folder
    assert loaded.pipe is not None
    texts = message_texts(folder, profile)
    bay = VirtualBay(profile, loaded.pipe, texts, Switches(), seed, start_values(loaded))
    plan = read_plan(folder, profile, loaded.robot)
    return World(loaded, bay, VirtualPort(bay, plan.serial.heartbeat_within, plan.wanted))


def prepared_on(it: World, port: VirtualPort) -> Prepared:
    """Return the mission on this port, with a detector that knows where the robot truly is."""
    loaded, robot = it.loaded, it.bay.robot
    profile = loaded.loaded_robot.profile
    plan = read_plan(loaded.loaded_robot.folder, profile, loaded.robot)
    backend = SerialBackend(plan, port)
    places = Places(robot.bends, lambda: robot.arcs_m)
    says = detecting("sim", "sim", Asked(profile, loaded.robot, loaded.pipe, places=places))
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    companions = (Holder(backend.hold), *says.companions, FirstChoice())
    order = Order(loaded.mission.mission, "serial", port="virtual")
    return Prepared(
        backend=backend, loaded=loaded, companions=companions, order=order, engine=engine,
        detecting=says,
    )  # fmt: skip


def ride_on(
    prepared: Prepared,
    grip: _Grip,
    until_s: float = MOST_S,
    path: Path | None = None,
    resuming: Resuming | None = None,
) -> tuple[Trace, Pump]:
    """Run the mission until this time, and write what is recorded by then to the file."""
    header = replace(run_header(prepared, inf, datetime.now(UTC)), viewers=False)
    memory = _Memory()
    kept = RunRecorder(prepared, header, RecordingFile(memory, header)) if path else None
    tap = kept.recorder if kept is not None else None
    if tap is not None:
        tap.ahead_s = MOST_S  # in virtual time nothing is late
    course: list[tuple[str, ...]] = []

    def note(effects: Sequence[object], now_s: float) -> None:
        state = pump.state
        if state is not None:
            names = states_of(prepared.loaded.robot, state.robot)
            if not course or course[-1] != names:
                course.append(names)

    pump = Pump(
        prepared.engine, prepared.backend, companions=prepared.companions, tell=note, tap=tap,
        resuming=resuming,
    )  # fmt: skip
    if kept is not None:
        kept.follow(prepared, lambda: pump.state)
    pump.start()
    written_s = pump.now_s
    while pump.ended is None and pump.now_s < until_s:
        pump.take(*pump.wait(until_s))
        state = pump.state
        if state is not None:
            now_s = prepared.backend.port.now()  # type: ignore[attr-defined]
            grip.look(now_s, prepared.loaded.program.phase_of[state.mission.pc])
        if tap is not None and pump.now_s >= written_s + WRITTEN_EVERY_S:
            written_s = pump.now_s
            tap.secure()
    if path is not None and tap is not None:
        path.write_bytes(memory.data)
        tap.close()
    ended = pump.ended
    outcome, message = (ended.outcome, ended.message) if ended is not None else ("", "")
    return Trace(tuple(course), outcome, message, pump.now_s, frozenset(grip.loose)), pump


@cache
def alone(mission: str, seed: int) -> Trace:
    """Return what the mission does if nobody disturbs it."""
    it = world(mission, seed)
    trace, _ = ride_on(prepared_on(it, it.port), _Grip(it.loaded, it.bay))
    return trace


def ride(case: Case, operator: bool = True) -> Ride:
    """Cut a mission off, resume it, and judge it.

    Args:
        case: The case.
        operator: Whether a person agrees to what nobody has seen, and says where the robot is.
    """
    whole, it = alone(case.mission, case.seed), world(case.mission, case.seed)
    grip = _Grip(it.loaded, it.bay)
    with TemporaryDirectory() as folder:
        path = Path(folder, "cut.mcap")
        first = prepared_on(it, it.port)
        before, pump = ride_on(first, grip, case.share * whole.until_s, path)
        phase = ""
        if pump.state is not None:
            phase = it.loaded.program.phase_of[pump.state.mission.pc]
        _kill(case, it, grip, phase)
        it = LIES[case.lie](it, path) if case.lie else it
        try:
            end = end_of_run(path)
            port = it.port.next_port()
            found = _resumed(prepared_on(it, port), end, case, it, operator)
        except PirateError as error:
            return Ride(case, "refused", str(error), phase=phase)
        if lost := grip.loose - whole.loose:
            return Ride(case, "let go", f"in the dark, in {', '.join(sorted(lost))}", phase=phase)
        if isinstance(found, str):
            return Ride(case, "refused", found, phase=phase)
        prepared, resuming, asked = found
        after, _ = ride_on(prepared, grip, inf, None, resuming)
    if lost := grip.loose - whole.loose:
        return Ride(case, "let go", f"in {', '.join(sorted(lost))}", asked, phase=phase)
    how = "success" if after.outcome == "succeeded" else "failure"
    same = _same(before, after, whole)
    return Ride(case, how, after.message, asked, same, phase)


def _same(before: Trace, after: Trace, whole: Trace) -> bool:
    """Return whether both together went through the configurations of the run left alone."""
    joined = list(before.configurations)
    for each in after.configurations:
        if not joined or joined[-1] != each:
            joined.append(each)
    return tuple(joined) == whole.configurations and after.outcome == whole.outcome


def _resumed(
    prepared: Prepared, end: EndOfRun, case: Case, it: World, operator: bool
) -> tuple[Prepared, Resuming, tuple[str, ...]] | str:
    """Return with what it goes on and what a person had to agree to, or why it does not."""
    seen = see(prepared, end, driven_s(end, case.dark_s))
    found = offer(prepared, end, seen, Said())
    asked = found.doubts
    if asked and not operator:
        return "; ".join(asked)
    if asked and not seen.shows.way.exact:
        found = offer(prepared, end, seen, Said(start_at_m=it.bay.truth.arcs_m[0]))
    if found.it is None:
        return "; ".join(found.refusals)
    resumed = with_resumption(prepared, end, found.it)
    return resumed, Resuming(found.it, seen.look.now_s, seen.look.newest), asked


def _kill(case: Case, it: World, grip: _Grip, phase: str) -> None:
    """Let something die, and time pass in which nobody records."""
    port, until_s = it.port, it.port.now() + case.dark_s
    if case.kind in ("bay", "power"):
        it.bay.robot.electronics.restart()  # its motors stop at once, and its counters are lost
    if case.kind in ("runner", "bay"):
        port.die(port.now())
    else:
        port.abandon()
    while port.now() < until_s:
        port.wait(port.now() + LOOSE_S / 3)
        grip.look(port.now(), phase)


# --- lies -------------------------------------------------------------------------------------


def _move_by_hand(it: World, path: Path) -> World:
    """Push the robot 50 mm on; its wheels roll."""
    state = it.bay.robot.physics.state  # type: ignore[attr-defined]
    state.position[:, 0] += 0.05
    state.wheel += 0.05 / it.loaded.loaded_robot.profile.body.wheel_radius
    return it


def _stick(it: World, path: Path) -> World:
    """Let one joint's sensor show half a turn more."""
    signal = it.loaded.loaded_robot.profile.body.joints[0].name
    it.bay.robot.electronics.shift(signal, 500.0)
    return it


def _cut(it: World, path: Path) -> World:
    """Lose the end of the file."""
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * 0.9)])
    return it


def _other_robot(it: World, path: Path) -> World:
    """Connect another robot, which stands at the start of the pipe."""
    return world(it.loaded.mission.mission, 1)


def _exchange(it: World, path: Path) -> World:
    """Exchange a byte in the middle of the file."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    return it


LIES: dict[str, Callable[[World, Path], World]] = {
    "moved by hand": _move_by_hand,
    "stuck joint": _stick,
    "other robot": _other_robot,
    "cut file": _cut,
    "damaged file": _exchange,
}
