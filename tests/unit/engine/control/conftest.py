"""The newt with tracks that are kept at a speed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from driving import IDLE, Driver, changed_newt

LOOP = ("    dead_drag: 30 mNm\n", "    dead_drag: 30 mNm\n    velocity_loop: {gain: 0.3}\n")
AHEAD = (
    "Ahead: {drive_a: 80 %, drive_b: -80 %, drive_c: 80 %, drive_d: -80 %}",
    "Ahead: {drive_a: 60 mm/s, drive_b: -60 mm/s, drive_c: 60 mm/s, drive_d: -60 mm/s}",
)
ASTERN = (
    "Astern: {drive_a: -80 %, drive_b: 80 %, drive_c: -80 %, drive_d: 80 %}",
    "Astern: {drive_a: -60 mm/s, drive_b: 60 mm/s, drive_c: -60 mm/s, drive_d: 60 mm/s}",
)
HELD = {"Grip": "BothHeld", "Crawl": "Resting", "Lamp": "Dark"}


@pytest.fixture
def newt(drive: Callable[..., Driver], tmp_path: Path) -> Callable[..., Driver]:
    """Starts an engine on the newt, which holds both parts and rests unless said otherwise."""

    def start(body: str = IDLE, *swaps: tuple[str, str], **options: Any) -> Driver:
        robot = changed_newt(tmp_path, LOOP, AHEAD, ASTERN, *swaps)
        return drive(body, robot, **{"states": HELD, **options})

    return start
