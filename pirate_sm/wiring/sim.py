"""Makes the backend ``sim``: the kinematic simulator with the mission's pipe and robot."""

from __future__ import annotations

from pirate_sm.detectors.registry import Places
from pirate_sm.engine.robot.robot_state import at_rest_in
from pirate_sm.errors import Hint, UsageError
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.robot.twin_file import simulated_profile
from pirate_sm.registry import Plugin
from pirate_sm.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.wiring.run_order import USE_TRACE, Order

COMPILING = (
    "Compiling the simulator to machine code for this processor, so that it runs hundreds of "
    "times faster than real time: some ten seconds, once ..."
)

_COMPILED = {"llvmlite", "numba", "numpy"}
"""The packages that the extra `sim` installs."""


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the simulator with the robot at the mission's start.

    Raises:
        LoadError: The file with the robot's numbers cannot be used.
        UsageError: There is no pipe, an option is for another backend, or the extra ``sim`` is not
            installed.
    """
    if loaded.pipe is None:
        hint = Hint(": give one with --pipe NAME", ": give one with pipe='NAME'")
        raise UsageError("the mission names no pipe to simulate", hint=hint)
    if order.firings or order.course:
        raise UsageError("triggers can be fired in a trace only", hint=USE_TRACE)
    try:
        from pirate_sm.backends.simulated import SimulatorBackend
        from pirate_sm.simulation.surroundings import Jitter
        from pirate_sm.simulation.xpbd.world import is_compiled
    except ModuleNotFoundError as error:
        if error.name not in _COMPILED:
            raise
        raise UsageError(
            f"the simulator needs {error.name}, which is not installed: "
            "pip install 'pirate-sm[sim]' (or use the backend trace)"
        ) from None
    if not is_compiled():
        say(COMPILING)
    backend = SimulatorBackend(
        simulated_profile(loaded.loaded_robot.profile, order.twin),
        loaded.pipe,
        seed=order.seed,
        start_values=start_values(loaded),
        jitter=Jitter(order.start_jitter_m, order.friction_jitter, order.diameter_jitter_m),
        defects=order.defects,
    )
    return Equipment(
        backend=backend,
        usual_detector="sim",
        places=Places(backend.crossings_m, lambda: backend.arcs_m),
        truth=lambda: backend.truth,
        wheels=lambda: backend.wheels,
    )


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


BACKEND: Plugin[MakeBackend] = Plugin("the kinematic simulator", make)
