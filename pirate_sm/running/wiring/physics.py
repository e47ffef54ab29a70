"""Makes the backend ``physics``: a simulated robot that MuJoCo moves."""

from __future__ import annotations

from pirate_sm.core.errors import not_installed
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.registry import Plugin
from pirate_sm.robot.backends import known
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say
from pirate_sm.running.wiring.run_order import Order
from pirate_sm.running.wiring.sim import check_order, simulated


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
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


BACKEND: Plugin[MakeBackend] = Plugin(known.ABOUT["physics"], make)
