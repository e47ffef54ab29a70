"""Makes the backends: each from the order of a run and its loaded mission.

What a backend needs is imported when it is made, so that no run loads another's libraries.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.core.documents import read_document
from pirate_sm.core.errors import Hint, UsageError, not_installed
from pirate_sm.core.loading import LoadedMission, simulated_profile
from pirate_sm.core.models import LineFaults, Pipe, Profile
from pirate_sm.core.options import JITTER, written
from pirate_sm.core.program import Wait
from pirate_sm.core.registry import Plugin
from pirate_sm.core.robot import at_rest_in
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import DIMENSIONLESS, LENGTH
from pirate_sm.robot import part_names
from pirate_sm.robot.backends import trace_script
from pirate_sm.robot.backends.trace import IDEAL, SCRIPTED, TraceBackend, Verdicts
from pirate_sm.robot.backends.trace_script import Happening, resolve_course
from pirate_sm.robot.calibration_files import newest_calibration, summary, with_zeros
from pirate_sm.robot.detectors.registry import Places
from pirate_sm.robot.detectors.simple_detectors import Ruler
from pirate_sm.running.runtime.backend_links import Holder, Messenger, SlideWatch
from pirate_sm.running.runtime.scripted_events import (
    CoursePlayer,
    Firing,
    LoopWatch,
    TriggerScript,
    longest_s,
)
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Order, Say

if TYPE_CHECKING:
    from pirate_sm.simulation.physics import MakePhysics
    from pirate_sm.simulation.surroundings import Jitter


# --- sim ------------------------------------------------------------------------------------------


COMPILING = (
    "Compiling the simulator to machine code for this processor, as none was built for this copy "
    "of it: some ten seconds, once ..."
)


def _sim(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the simulator with the robot at the mission's start.

    Raises:
        LoadError: The file with the robot's numbers cannot be used.
        UsageError: There is no pipe, or the simulator is neither
            built nor can it compile itself.
    """
    check_order(order, loaded)
    from pirate_sm.simulation.kinematic.world import is_compiled, kinematic, notice_of

    assert loaded.pipe is not None  # as checked above
    if not is_compiled(loaded.pipe.section):
        say(COMPILING)
    equipment = simulated(order, loaded, partial(kinematic, fidelity=order.fidelity))
    notice = notice_of(order.fidelity)
    return replace(equipment, notices=(notice,)) if notice else equipment


def check_order(order: Order, loaded: LoadedMission) -> None:
    """Check that an order can be simulated.

    Raises:
        UsageError: There is no pipe, or a jitter is too large.
    """
    if loaded.pipe is None:
        hint = Hint(": give one with --pipe NAME", ": give one with pipe='NAME'")
        raise UsageError("the mission names no pipe to simulate", hint=hint)
    if wrong := _senseless(order, loaded.pipe):
        raise UsageError("; ".join(wrong))


_MOST_OF_DIAMETER = 0.1
"""Of its diameter a pipe differs from its file by less than this share [decided]."""


def _senseless(order: Order, pipe: Pipe) -> list[str]:
    """Return what is wrong with how far a run may differ from its files."""
    length_m, most_m = pipe.route().length_m, _MOST_OF_DIAMETER * pipe.diameter
    bounds = {
        "start": (length_m, f"the length of the pipe, {length_m:g} m"),
        "friction": (1.0, "100 %"),
        "diameter": (most_m, f"{written(most_m, LENGTH)}, a tenth of the pipe's"),
    }
    return [
        f"jitter of the {each.key}: expected from 0 to below {bounds[each.key][1]}, "
        f"got {written(value, each.unit or DIMENSIONLESS)}"
        for each, value in zip(JITTER, order.jitter.values(), strict=True)
        if not 0 <= value < bounds[each.key][0]
    ]


def _simulated_files(order: Order, loaded: LoadedMission) -> tuple[Profile, Pipe, Jitter]:
    """Return the simulated robot and pipe of an order that was checked, and its jitter."""
    from pirate_sm.simulation.changed_pipe import changed_pipe

    assert loaded.pipe is not None  # as check_order has seen
    profile = simulated_profile(loaded.loaded_robot.profile, order.twin, order.seed, order.numbers)
    return profile, *changed_pipe(loaded.pipe, profile, order.numbers, order.jitter)


def simulated(order: Order, loaded: LoadedMission, physics: MakePhysics) -> Equipment:
    """Return a simulated robot that a physics moves, where the mission begins."""
    from pirate_sm.simulation.backend import SimulatorBackend

    profile, pipe, jitter = _simulated_files(order, loaded)
    backend = SimulatorBackend(
        profile,
        pipe,
        seed=order.seed,
        start_values=start_values(loaded),
        jitter=jitter,
        defects=order.defects,
        put_back=order.put_back,
        physics=physics,
        name=order.backend,
    )
    flat = pipe.section == "bars"
    return Equipment(
        backend=backend,
        companions=(
            SlideWatch(backend.places_m),
            *_ruler(order, loaded, lambda: (backend.moved_until_s, backend.robot.arcs_m)),
        ),
        usual_detector="sim",
        places=Places(backend.robot.bends, backend.places_m),
        truth=lambda: backend.truth,
        wheels=lambda: backend.robot.wheels,
        in_space=None if flat else lambda: backend.robot.in_space,
        rolls=(lambda: backend.robot.in_space.rolls_rad) if flat else None,
    )


def _ruler(
    order: Order, loaded: LoadedMission, places: Callable[[], tuple[float, Sequence[float]]]
) -> tuple[Ruler, ...]:
    """Return the ruler, if the run has one.

    Raises:
        UsageError: The robot's profile describes no ruler.
    """
    if not order.ruler:
        return ()
    settings = loaded.loaded_robot.profile.simulation.ruler
    if settings is None:
        message = f"the profile of {loaded.robot.name} describes no ruler"
        raise UsageError(message, hint=Hint(": leave out --ruler", ": leave out ruler=True"))
    return (Ruler(settings, places, order.seed),)


def start_values(loaded: LoadedMission) -> tuple[float, ...] | None:
    """Return setpoints that hold a simulated robot in its start configuration; None at rest.

    Only joints of held parts are driven. A bending part is not in a bend yet: pushed in a straight
    pipe it would lever the held part off the wall before the first command.
    """
    configuration, robot = loaded.program.start_configuration, loaded.robot
    if configuration == robot.table.initial:
        return None
    profile = loaded.loaded_robot.profile
    held = {robot.parts[part] for part in robot.held[configuration]}
    free = {joint.name for joint in profile.body.joints if joint.part not in held}
    values = at_rest_in(robot, configuration).values
    return tuple(
        0.0 if slot.joint in free else value
        for slot, value in zip(profile.slots, values, strict=True)
    )


# --- physics --------------------------------------------------------------------------------------


def _physics(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the robot in MuJoCo's world, where the mission begins.

    Raises:
        UsageError: There is no pipe, the extra ``physics`` is not
            installed, the sensors are not built, or a viewer is asked for and there is no display.
    """
    check_order(order, loaded)
    try:
        from pirate_sm.simulation.mujoco.world import MujocoWorld

        if order.view:
            from pirate_sm.simulation.mujoco.viewer import WatchedWorld as MujocoWorld
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise not_installed("the backend physics", "mujoco", "physics") from None
    return simulated(order, loaded, MujocoWorld)


# --- bay ------------------------------------------------------------------------------------------


def without_messages(error: ModuleNotFoundError) -> UsageError:
    """Return what to say where the library of message definitions is not installed.

    Raises:
        ModuleNotFoundError: Another module is missing.
    """
    if error.name is None or error.name.partition(".")[0] != "rosbags":
        raise error
    return not_installed("the emulated bay", error.name, "serial")


def _bay(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the driver of the link, its guardian and an emulated bay, where the mission begins.

    Raises:
        UsageError: There is no pipe or no serial link, or a library is missing.
    """
    check_order(order, loaded)
    try:
        from pirate_sm.robot.backends.serial.assembly import read_plan
        from pirate_sm.robot.backends.serial.backend import SerialBackend
        from pirate_sm.simulation.bay.bay_defects import Switches
        from pirate_sm.simulation.bay.node_handle import message_texts
        from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort
    except ModuleNotFoundError as error:
        raise without_messages(error) from None
    profile, pipe, jitter = _simulated_files(order, loaded)
    robot = loaded.loaded_robot
    plan = read_plan(robot.folder, robot.profile, loaded.robot)
    line = order.line or LineFaults()
    bay = VirtualBay(
        profile,
        pipe,
        message_texts(robot.folder, robot.profile),
        Switches(
            line.loss_in,
            line.loss_out,
            corruption=line.corruption,
            delay_s=line.delay,
            jitter_s=line.jitter,
            cut_at_s=line.cut_after or inf,
            reset_every_s=line.reset_every,
            defects=order.defects,
        ),
        order.seed,
        start_values(loaded),
        jitter=jitter,
    )
    from pirate_sm.robot.diagnosis.facts import ExpectedRobot
    from pirate_sm.robot.diagnosis.listening import OpenLink

    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    return Equipment(
        backend=backend,
        companions=(
            Holder(backend.hold),
            SlideWatch(lambda: bay.robot.arcs_m, lambda: bay.robot.left_pipe),
        ),
        usual_detector="odometry",
        places=Places(bay.robot.bends, lambda: bay.robot.arcs_m),
        truth=lambda: bay.truth,
        wheels=lambda: bay.robot.wheels,
        in_space=None if pipe.section == "bars" else lambda: bay.robot.in_space,
        link=lambda: backend.health,
        open_link=OpenLink(ExpectedRobot(robot.profile, loaded.robot, plan), backend),
    )


# --- serial ---------------------------------------------------------------------------------------


def _serial(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the link to the robot at the order's port, without opening the port.

    Raises:
        UsageError: There is no port.
    """
    if not order.port:
        or_url = "or a pyserial URL"
        hint = Hint(f": --port /dev/ttyACM0, {or_url}", f": port='/dev/ttyACM0', {or_url}")
        raise UsageError("the backend serial needs a port", hint=hint)
    from pirate_sm.robot.backends.serial.assembly import STAY_S, read_plan, serial_backend
    from pirate_sm.robot.diagnosis.facts import ExpectedRobot
    from pirate_sm.robot.diagnosis.listening import OpenLink

    loaded, notices = calibrated(order, loaded)
    profile = loaded.loaded_robot.profile
    plan = read_plan(loaded.loaded_robot.folder, profile, loaded.robot)
    stay_s = STAY_S if order.guard_for_s is None else order.guard_for_s
    backend = serial_backend(plan, order.port, order.baud, stay_s)
    return Equipment(
        backend=backend,
        loaded=loaded,
        companions=(Holder(backend.hold), Messenger(backend.remark)),
        notices=notices,
        usual_detector="odometry",
        link=lambda: backend.health,
        open_link=OpenLink(ExpectedRobot(profile, loaded.robot, plan), backend),
        parting=backend.parting,
        confirmation=f"{profile.robot} on {order.port} is about to move",
        adapted=lambda other: calibrated(order, other)[0],
    )


def calibrated(order: Order, loaded: LoadedMission) -> tuple[LoadedMission, tuple[str, ...]]:
    """Return the mission with the joint zeros of its robot, and a notice about them.

    Without zeros, or if the order does not want them, the mission is unchanged, without a notice.
    """
    calibration = newest_calibration(loaded.loaded_robot) if order.calibration else None
    if calibration is None:
        return loaded, ()
    robot = with_zeros(loaded.robot, calibration.zeros)
    return replace(loaded, robot=robot), (summary(calibration),)


# --- trace ----------------------------------------------------------------------------------------


def _trace(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return a trace, with the companions that fire triggers in it.

    Raises:
        UsageError: No wait has a trigger to be fired.
    """
    if order.course:
        return _course(order, loaded)
    _check_firings(order.firings, loaded)
    script = TriggerScript(loaded.program, order.firings)
    watch = LoopWatch(lambda: len(script.unused))
    return Equipment(backend=TraceBackend(), companions=(watch, script), notices=(IDEAL,))


def _course(order: Order, loaded: LoadedMission) -> Equipment:
    """Return a trace that plays an event sequence."""
    if order.firings:
        raise UsageError("an event sequence cannot be combined with triggers to fire")
    events = resolve_course(order.course, loaded.robot)
    names = [each.report for each in events if each.happening.happens == "start" and each.report]
    later = [each for each in events if each.happening.happens != "start"]
    verdicts = Verdicts(scripted=True)
    program = loaded.program
    player = CoursePlayer(later, program, verdicts.decide, verdicts.release)
    # The duration of commands in a trace must not count against a time limit.
    limit_s = program.time_limit_s + longest_s(order.course, loaded.robot, program)
    return Equipment(
        backend=TraceBackend(verdicts, names),
        loaded=replace(loaded, program=replace(program, time_limit_s=limit_s)),
        companions=(player,),
        notices=(SCRIPTED,),
        attended=True,
    )


def read_script(path: Path) -> tuple[tuple[Firing, ...], tuple[Happening, ...]]:
    """Return the firings in a file, or its whole event sequence.

    Raises:
        LoadError: The file has errors; it lists all of them.
    """
    script = trace_script.read_script(read_document(path))
    firings = (Firing(each.trigger, each.after, each.phase) for each in script.entries)
    return tuple(firings), script.course


def _check_firings(firings: tuple[Firing, ...], loaded: LoadedMission) -> None:
    waits = [each for each in loaded.program.instructions if isinstance(each, Wait)]
    phases = {wait.phase for wait in waits}
    asked: dict[str, list[str]] = {}
    for firing in firings:
        asked.setdefault(firing.phase, []).append(firing.trigger)
    named = [phase for phase in asked if phase]
    wrong = [unknown("nothing waits in a phase", named, sorted(phases))]
    for phase, triggers in asked.items():
        here = [wait for wait in waits if phase in ("", wait.phase)]
        known = {trigger.name for wait in here for trigger in wait.triggers} | {"within"}
        if here:
            where = f"in the phase '{phase}' " if phase else ""
            wrong.append(unknown(f"nothing {where}waits for a trigger", triggers, sorted(known)))
    if any(wrong):
        raise UsageError("\n".join(filter(None, wrong)))


# --- the plugins ----------------------------------------------------------------------------------

SIM: Plugin[MakeBackend] = Plugin(part_names.BACKENDS["sim"], _sim)
PHYSICS: Plugin[MakeBackend] = Plugin(part_names.BACKENDS["physics"], _physics)
BAY: Plugin[MakeBackend] = Plugin(part_names.BACKENDS["bay"], _bay)
SERIAL: Plugin[MakeBackend] = Plugin(part_names.BACKENDS["serial"], _serial)
TRACE: Plugin[MakeBackend] = Plugin(part_names.BACKENDS["trace"], _trace)
