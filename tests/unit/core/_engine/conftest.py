"""Missions written in a test, driven by hand."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from driving import PIRATE, Driver, driver_of, write_mission


@pytest.fixture
def drive(tmp_path: Path) -> Callable[..., Driver]:
    """Writes a mission's body to a file and starts an engine on it."""

    def start(body: str, robot: Path = PIRATE, **options: Any) -> Driver:
        return driver_of(write_mission(tmp_path, body, robot), **options)

    return start
