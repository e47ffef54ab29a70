"""What the options of a run and of the console order."""

from __future__ import annotations

from typing import Any

import pytest

from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.cli.order import order_of
from pirate_sm.errors import UsageError
from pirate_sm.runtime.trigger_script import Firing
from pirate_sm.wiring import Order

SHARED: dict[str, Any] = {
    "mission": "m.yaml",
    "backend": "serial",
    "robot": "r",
    "pipe": "p",
    "settings": ["a=1"],
    "states": ["Front=Held"],
    "seed": 7,
    "defects": ["late", "late"],
    "fidelity": "fast",
    "port": "/dev/x",
    "baud": 9600,
    "guard_for": "2 min",
    "detector": "odometry",
    "start_at": "0.7 m",
    "calibration": False,
    "check": False,
}
ORDER = Order(
    mission="m.yaml",
    backend="serial",
    robot="r",
    pipe="p",
    settings={"a": "1"},
    states={"Front": "Held"},
    seed=7,
    defects=("late",),
    fidelity="fast",
    port="/dev/x",
    baud=9600,
    guard_for_s=120.0,
    detector="odometry",
    start_at_m=0.7,
    calibration=False,
    check=False,
)


def test_a_run_and_the_console_order_the_same_by_the_same_options() -> None:
    assert order_of(RunOptions(**SHARED)) == ORDER
    assert order_of(ConsoleOptions(**SHARED)) == ORDER


def test_options_that_are_left_out_are_those_of_an_order() -> None:
    assert order_of(RunOptions(mission="m")) == Order("m", check=True)


def test_triggers_are_fired_in_order() -> None:
    order = order_of(RunOptions(mission="m", backend="trace", fire=["past=2.5", "home"]))

    assert order.firings == (Firing("past", 2.5), Firing("home", None))


@pytest.mark.parametrize("text", ["past=soon", "past=-1", "past=inf"])
def test_a_trigger_fires_after_seconds(text: str) -> None:
    with pytest.raises(UsageError, match="expected TRIGGER or TRIGGER=SECONDS"):
        order_of(RunOptions(mission="m", fire=[text]))
