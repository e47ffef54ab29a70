"""MuJoCo's own viewer beside a run."""

from __future__ import annotations

import os
import sys
import weakref
from typing import Any

import mujoco.viewer

from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.geometry import Route
from pirate_sm.core.models import Friction
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, StartPose

_WITHOUT = Hint(
    ": leave --view out, and watch the run with --live or from its recording",
    ": leave view out, and look at the recording",
)


class WatchedWorld(MujocoWorld):
    """A world that MuJoCo's viewer shows after each cycle, until its window is closed.

    Arguments as of :class:`~pirate_sm.simulation.mujoco.world.MujocoWorld`.

    Raises:
        UsageError: There is no display.
    """

    def __init__(
        self, chain: ChainBody, route: Route, friction: Friction, pose: StartPose, cycle_s: float
    ) -> None:
        super().__init__(chain, route, friction, pose, cycle_s)
        self._window = open_window(self)
        # The window's thread must have ended before the process does.
        weakref.finalize(self, self._window.close)
        x, y, z = pose.places[len(pose.places) // 2]
        self._window.cam.lookat[:] = (x, y, z)
        self._window.cam.distance = chain.length_m * 2.0
        # From above: z of the drawing points down.
        self._window.cam.elevation = 60.0

    def advance(self) -> None:
        """Let one cycle pass and show it."""
        super().advance()
        if self._window.is_running():
            self._window.sync()


def open_window(world: MujocoWorld) -> Any:
    """Return the handle of a window that shows a world.

    Raises:
        UsageError: There is no display, or it cannot be used from this process.
    """
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise UsageError(
            "there is no display here for MuJoCo's viewer (DISPLAY is not set)", hint=_WITHOUT
        )
    try:
        return mujoco.viewer.launch_passive(
            world.model, world.data, show_left_ui=False, show_right_ui=False
        )
    except (RuntimeError, mujoco.FatalError) as error:
        raise UsageError(f"MuJoCo's viewer cannot be opened: {error}", hint=_WITHOUT) from error
