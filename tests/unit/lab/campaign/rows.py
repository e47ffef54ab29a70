"""Plans and results made by hand, and a crew that returns them in any order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import nan
from random import Random

from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule, TrueEnd
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.crew import Done
from pirate_sm.lab.campaign.plan import CampaignPlan, Cell
from pirate_sm.running.wiring import Order


def cell(
    name: str = "bend", seeds: Sequence[int] = range(100), expect: Expectation | None = None
) -> Cell:
    order = Order("mitre_bend", defects=("wheels_3_4_dead",), start_jitter_m=0.02)
    return Cell(name, "", order, seeds, TrueEnd(), expect or Expectation(), f"key_{name}", "m")


def plan(*cells: Cell, stop: StoppingRule | None = None) -> CampaignPlan:
    return CampaignPlan("trial", "1+a", cells, 0.95, stop or StoppingRule(), {"m": b""})


OUTCOMES = {"passed": "succeeded", "false": "succeeded", "failed": "failed", "bug": "bug"}
"""What a mission says, by what it was in truth."""


def row(
    key: str,
    seed: int,
    verdict: str = "passed",
    why: str = "",
    time_s: float = 30.0,
    *,
    unsafe: str = "",
    short_m: float = nan,
    deepest_m: float = nan,
) -> RunRow:
    passed = verdict == "passed"
    why = "" if passed else why or "Holding"
    outcome = OUTCOMES[verdict]
    return RunRow(key, seed, outcome, verdict, why, passed, unsafe, time_s, 0.8, short_m, deepest_m)


def fails(seed: int) -> bool:
    """One run of seven fails."""
    return seed * 2654435761 % 2**32 < 2**32 // 7


def result(chunk: Chunk, seed: int) -> RunRow:
    return row(chunk.cell, seed, "failed" if fails(seed) else "passed", time_s=20.0 + seed % 7)


class Hasty:
    """A crew whose chunks come back in an order of chance, with ``each`` runs or all of them."""

    def __init__(
        self,
        seed: int,
        room: int = 8,
        result: Callable[[Chunk, int], RunRow] = result,
        each: int | None = None,
    ) -> None:
        self.each = each
        self.random, self.most, self.result = Random(seed), room, result
        self.under_way: list[Chunk] = []
        self.given: list[int] = []

    @property
    def room(self) -> int:
        return self.most - len(self.under_way)

    def submit(self, chunk: Chunk) -> None:
        self.under_way.append(chunk)
        self.given += chunk.seeds

    def wait(self, within_s: float) -> Sequence[Done]:
        assert self.under_way, "nothing will ever come"
        self.random.shuffle(self.under_way)
        chunk = self.under_way.pop()
        return [Done(chunk, [self.result(chunk, seed) for seed in chunk.seeds[: self.each]])]
