from __future__ import annotations

import pytest

from pirate_sm.running.wiring import Order, load
from pirate_sm.views.console.hand_back import waits_before


@pytest.mark.parametrize(
    ("phase", "waiting"),
    [
        ("enter", []),
        ("prepare", ["enter"]),
        ("pass/pass_bend.pass", ["enter", "prepare"]),
        ("halt", ["enter", "prepare", "pass"]),
        ("no_bend", []),  # the wait that leads there has run out
        ("regrip", []),  # a failure leads there from anywhere
    ],
)
def test_waits_are_those_that_every_way_to_the_phase_passes(phase: str, waiting: list[str]) -> None:
    program = load(Order("mitre_bend", backend="trace")).program

    assert [each.phase for each in waits_before(program, phase)] == waiting
