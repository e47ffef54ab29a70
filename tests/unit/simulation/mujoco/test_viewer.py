from __future__ import annotations

from typing import Any

import mujoco.viewer
import pytest
from viewer_window import Window

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Route
from pirate_sm.core.models import Friction
from pirate_sm.simulation.mujoco.viewer import WatchedWorld
from pirate_sm.simulation.physics import ChainBody
from pirate_sm.simulation.start_pose import stand

from ..conftest import CYCLE_S, straight


def watched(chain: ChainBody) -> WatchedWorld:
    route = Route(straight())
    friction = Friction(static=0.7, kinetic=0.5)
    return WatchedWorld(chain, route, friction, stand(chain, route, 1.0, {}), CYCLE_S)


def test_each_cycle_is_shown_until_the_window_is_closed(
    chain: ChainBody, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = Window()
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setattr(mujoco.viewer, "launch_passive", lambda *model, **options: window)
    world = watched(chain)
    for _ in range(3):
        world.advance()
    assert window.shown == 3
    assert list(window.cam.lookat) == pytest.approx([0.722, 0.0, 0.0])
    window.close()
    world.advance()
    assert window.shown == 3
    assert world.data.time == pytest.approx(4 * CYCLE_S)


def test_a_window_that_cannot_be_opened_is_a_wrong_option(
    chain: ChainBody, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*model: Any, **options: Any) -> None:
        raise RuntimeError("`launch_passive` requires mjpython")

    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setattr(mujoco.viewer, "launch_passive", refuse)
    with pytest.raises(UsageError, match="requires mjpython"):
        watched(chain)
