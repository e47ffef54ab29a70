"""The controller's ring of 64 bytes holds whatever the driver writes, on any line."""

from __future__ import annotations

from pathlib import Path

import pytest
from representative import thorough_but

from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

from .conftest import ROOT, SIX_WHEELED

LINES = {
    "clean": Switches(),
    "bad": Switches(0.2, 0.2, corruption=0.01),
    "no echo": Switches(loss_out=0.9),
    "restarts": Switches(0.2, 0.2, corruption=0.01, reset_every_s=5.0),
}
HASTE_S = 0.01
ARRAYS = 1_000


@pytest.fixture(scope="module")
def pipe() -> Path:
    return ROOT / "sequences" / "pipes" / "straight_113.yaml"


def driven_bay(plan: LinkPlan, pipe: Path, switches: Switches, seed: int) -> VirtualBay:
    """A bay that was given arrays far faster than the line takes them."""
    profile = load_robot(SIX_WHEELED).profile
    texts = message_texts(SIX_WHEELED, profile)
    bay = VirtualBay(profile, load_pipe(pipe)[0], texts, switches, seed=seed)
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    backend.open()
    now_s = 0.0
    for number in range(1, ARRAYS + 1):
        backend.submit(number, (0.0,) * 5 + (number / ARRAYS,) + (0.0,) * (len(plan.slots) - 6))
        until_s = now_s + HASTE_S
        while now_s < until_s:
            now_s, _ = backend.advance(until_s)
    backend.close()
    return bay


@pytest.mark.parametrize("line", thorough_but(["bad", "restarts"], LINES))
@pytest.mark.parametrize("seed", thorough_but(range(1), range(3)))
def test_it_never_overruns(plan: LinkPlan, pipe: Path, line: str, seed: int) -> None:
    bay = driven_bay(plan, pipe, LINES[line], seed)

    assert bay.last_applied is not None
    assert bay.overrun == 0
