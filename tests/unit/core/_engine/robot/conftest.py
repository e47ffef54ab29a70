"""The newt with tracks that are kept at a speed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from driving import IDLE, Driver
from rolling_newt import DRIVE, HELD, rolling_newt


@pytest.fixture
def newt(drive: Callable[..., Driver], tmp_path: Path) -> Callable[..., Driver]:
    """Starts an engine on the newt, which holds both parts and rests unless said otherwise."""

    def start(body: str = IDLE, *swaps: tuple[str, str], **options: Any) -> Driver:
        return drive(body, rolling_newt(tmp_path, *swaps), **{"states": HELD, **options})

    return start


@pytest.fixture
def loaded(newt: Callable[..., Driver]) -> Driver:
    """An engine on the mission that drives the newt, with sensors that must show what can be."""
    return newt(DRIVE, doubting=True)
