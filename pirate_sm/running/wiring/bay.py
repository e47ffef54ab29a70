"""Makes the backend ``bay``: the serial link to the emulated bay, in this process and its time."""

from __future__ import annotations

from math import inf

from pirate_sm.core.campaign import LineFaults
from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.core.loading import LoadedMission, simulated_profile
from pirate_sm.core.registry import Plugin
from pirate_sm.robot.backends import known
from pirate_sm.robot.detectors.registry import Places
from pirate_sm.running.runtime.backend_links import Holder, SlideWatch
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.running.wiring.run_order import Order
from pirate_sm.running.wiring.sim import check_order, start_values


def without_messages(error: ModuleNotFoundError) -> UsageError:
    """Return what to say where the library of message definitions is not installed.

    Raises:
        ModuleNotFoundError: Another module is missing.
    """
    if error.name is None or error.name.partition(".")[0] != "rosbags":
        raise error
    return not_installed("the emulated bay", error.name, "serial")


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the driver of the link, its guardian and an emulated bay, where the mission begins.

    Raises:
        UsageError: There is no pipe or no serial link, or a library is missing.
    """
    check_order(order, loaded)
    try:
        from pirate_sm.robot.backends.serial.assembly import read_plan
        from pirate_sm.robot.backends.serial.backend import SerialBackend
        from pirate_sm.simulation.bay.node_handle import message_texts
        from pirate_sm.simulation.bay.switches import Switches
        from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort
        from pirate_sm.simulation.surroundings import Jitter
    except ModuleNotFoundError as error:
        raise without_messages(error) from None
    assert loaded.pipe is not None  # as checked above
    robot = loaded.loaded_robot
    plan = read_plan(robot.folder, robot.profile, loaded.robot)
    line = order.line or LineFaults()
    bay = VirtualBay(
        simulated_profile(robot.profile, order.twin),
        loaded.pipe,
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
        jitter=Jitter(**order.jitter),
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
        in_space=None if loaded.pipe.section == "bars" else lambda: bay.robot.in_space,
        link=lambda: backend.health,
        open_link=OpenLink(ExpectedRobot(robot.profile, loaded.robot, plan), backend),
    )


BACKEND: Plugin[MakeBackend] = Plugin(known.ABOUT["bay"], make)
