from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.simulation.bay.bay_defects import Corruption, Switches


def rng(seed: int = 5) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_the_share_of_bytes_changed_is_the_one_asked_for() -> None:
    corruption = Corruption(0.01, rng())
    changed = sum(
        sum(a != b for a, b in zip(corruption.damage(bytes(7)), bytes(7), strict=True))
        for _ in range(20_000)
    )

    assert changed / 140_000 == pytest.approx(0.01, abs=0.001)


@pytest.mark.parametrize(
    ("switch", "kind"),
    [
        ({"reset_at_s": (5.0,)}, "controller_reset"),
        ({"reset_every_s": 5.0}, "controller_reset"),
        ({"spontaneous_at_s": (5.0,)}, "stray_motion"),
        ({"spontaneous_every_s": 5.0}, "stray_motion"),
        ({"stale_every_s": 5.0}, "stale_repeats"),
        ({"hang_at_s": 5.0}, "controller_hang"),
    ],
)
def test_a_switch_is_short_for_a_kind_of_defect(switch: dict[str, Any], kind: str) -> None:
    ((defect, _),) = Switches(**switch).more_defects(0, rng().spawn(3))
    assert defect.kind == kind
    assert 5.0 in (defect.after, defect.every)


def test_with_all_switches_off_there_is_no_defect() -> None:
    assert Switches().more_defects(0, rng().spawn(3)) == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"loss_in": 1.1},
        {"loss_out": 0.6, "never_two": True},
        {"corruption": -0.1},
        {"delay_s": -1.0},
        {"reset_at_s": (-1.0,)},
        {"ring": 0},
        {"poll_s": 0.0},
    ],
)
def test_switches_that_make_no_sense_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        Switches(**wrong)
