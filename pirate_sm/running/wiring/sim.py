"""Makes the backend ``sim``: the kinematic simulator with the mission's pipe and robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.loading import LoadedMission, simulated_profile
from pirate_sm.core.options import JITTER, written
from pirate_sm.core.pipe import Pipe
from pirate_sm.core.registry import Plugin
from pirate_sm.core.robot import at_rest_in
from pirate_sm.core.units import DIMENSIONLESS, LENGTH
from pirate_sm.robot.backends import known
from pirate_sm.robot.detectors.registry import Places
from pirate_sm.robot.detectors.ruler import Ruler
from pirate_sm.running.runtime.backend_links import SlideWatch
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.running.wiring.run_order import Order

if TYPE_CHECKING:
    from pirate_sm.simulation.physics import MakePhysics

COMPILING = (
    "Compiling the simulator to machine code for this processor, as none was built for this copy "
    "of it: some ten seconds, once ..."
)


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the simulator with the robot at the mission's start.

    Raises:
        LoadError: The file with the robot's numbers cannot be used.
        UsageError: There is no pipe, or the simulator is neither
            built nor can it compile itself.
    """
    check_order(order, loaded)
    from pirate_sm.simulation.xpbd.world import is_compiled, kinematic, notice_of

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


def simulated(order: Order, loaded: LoadedMission, physics: MakePhysics) -> Equipment:
    """Return a simulated robot that a physics moves, where the mission begins."""
    from pirate_sm.simulation.backend import SimulatorBackend
    from pirate_sm.simulation.surroundings import Jitter

    pipe = loaded.pipe
    assert pipe is not None  # as check_order has seen
    backend = SimulatorBackend(
        simulated_profile(loaded.loaded_robot.profile, order.twin),
        pipe,
        seed=order.seed,
        start_values=start_values(loaded),
        jitter=Jitter(**order.jitter),
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


BACKEND: Plugin[MakeBackend] = Plugin(known.ABOUT["sim"], make)
