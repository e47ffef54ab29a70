"""What a search has found is tried with other seeds, and kept as a scene that can be played."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from pirate_sm.cli.scene_steps import why_unplayable
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Recorded
from pirate_sm.lab.campaign.crew import DaskCrew
from pirate_sm.lab.campaign.falsified import KeptChange, keep
from pirate_sm.lab.campaign.falsify import FailingChange
from pirate_sm.lab.campaign.margins_model import MarginFactor
from pirate_sm.lab.campaign.plan import mark_of
from pirate_sm.lab.campaign.store import Store
from pirate_sm.lab.gallery.scene_file import load_scene
from pirate_sm.running.wiring import Order

from .rows import Hasty, cell, plan, row

MANY = tuple(MarginFactor(f"motors.bend_{n:02}.stall_torque", "Nm", 0, 2, 1) for n in range(20))


class Recording(Hasty):
    """A crew that can record, too."""

    def doing(self, work: Callable[..., Any]) -> Hasty:
        return Hasty(0, result=cast("Any", lambda chunk, seed: Recorded(chunk.cell, seed, b"mcap")))


def kept(folder: Path, found: RunRow, others: Callable[[int], str], factors: int = 1) -> KeptChange:
    one = replace(cell("climb", (0,)), order=Order("climb"), around=MANY[:factors])
    with_change = FailingChange((0.5,) * factors, found)

    def result(chunk: Chunk, seed: int) -> RunRow:
        return row(chunk.cell, seed, others(seed))

    store = Store(folder)
    store.begin(mark_of(plan(one)))
    change = keep(with_change, one, store, cast("DaskCrew", Recording(0, result=result)))
    store.close()
    return change


def test_only_seeds_with_the_same_result_are_counted(tmp_path: Path) -> None:
    def others(seed: int) -> str:
        return "false" if seed == 0 else "failed" if seed < 8 else "passed"

    assert kept(tmp_path / "a", row("climb", 0, "false"), others).seeds == 1
    assert kept(tmp_path / "b", row("climb", 0, "failed"), others).seeds == 7


@pytest.mark.parametrize("verdict", ["failed", "false"])
@pytest.mark.parametrize("factors", [1, 20])
def test_its_scene_can_be_played(tmp_path: Path, verdict: str, factors: int) -> None:
    found = row("climb", 0, verdict, why="it slips " * 200)
    change = kept(tmp_path, found, lambda seed: verdict, factors)
    scene = load_scene(
        Path(change.scene), lambda step: why_unplayable(step, {"out": tmp_path, "here": tmp_path})
    )

    (step,) = scene.steps
    assert step.expect.ended == found.outcome
    assert step.command.count("--number") == factors
    assert Path(change.recording).read_bytes() == b"mcap"


def test_an_internal_error_is_said_with_its_command_and_has_no_scene(tmp_path: Path) -> None:
    change = kept(tmp_path, row("climb", 0, "bug", "ZeroDivisionError: division by zero"),
                  lambda seed: "bug")  # fmt: skip
    said = "\n".join(change.lines())

    assert "least change with which an internal error ends it (size 0.50)" in said
    assert "ZeroDivisionError: division by zero; the same with 10 of 10 seeds" in said
    assert "pirate run climb --seed 0" in said
    assert "pirate demo" not in said
