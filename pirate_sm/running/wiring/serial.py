"""Makes the backend ``serial``: a real or an emulated robot behind a serial port."""

from __future__ import annotations

from dataclasses import replace

from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.registry import Plugin
from pirate_sm.robot.backends import known
from pirate_sm.running.runtime.backend_links import Holder, Messenger
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.running.wiring.run_order import Order


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
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
    from pirate_sm.core.loading import newest_calibration, summary, with_zeros

    calibration = newest_calibration(loaded.loaded_robot) if order.calibration else None
    if calibration is None:
        return loaded, ()
    robot = with_zeros(loaded.robot, calibration.zeros)
    return replace(loaded, robot=robot), (summary(calibration),)


BACKEND: Plugin[MakeBackend] = Plugin(known.ABOUT["serial"], make)
