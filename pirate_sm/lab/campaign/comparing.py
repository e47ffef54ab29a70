"""How the cells of two campaigns differ, and whether that is more than chance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from pirate_sm.lab.campaign.intervals import fisher_exact, mcnemar_exact
from pirate_sm.lab.campaign.tally import Tally

LEVEL = 0.05
"""Chance at which one of all the differences found would be none."""

_MOST_SEEDS = 10
"""The most seeds of a difference that are shown."""


@dataclass(frozen=True)
class CellDifference:
    """What differs between two cells of one name.

    Attributes:
        name: Of the cells.
        passed: Passed runs and runs of the first; likewise ``then`` of the second.
        chance: How likely so large a difference is by chance, two-sided.
        test: The exact test that says so: ``McNemar`` for runs in pairs of one seed, ``Fisher`` for
            independent ones.
        lost: Seeds that passed in the first and do not in the second; likewise ``gained``.
        significant: Whether it counts, with as many cells as were compared (Holm's correction).
    """

    name: str
    passed: tuple[int, int]
    then: tuple[int, int]
    chance: float
    test: Literal["McNemar", "Fisher"]
    lost: tuple[int, ...]
    gained: tuple[int, ...]
    significant: bool = False

    @property
    def worse(self) -> bool:
        """Whether the second is significantly worse."""
        fewer = self.then[0] * self.passed[1] < self.passed[0] * self.then[1]
        if self.test == "McNemar":
            fewer = len(self.lost) > len(self.gained)
        return self.significant and fewer


@dataclass(frozen=True)
class ComparedCampaigns:
    """Two campaigns.

    Attributes:
        differences: Of the cells that both have, in the order of the first.
        only_first: Names of cells of the first alone; likewise ``only_second``.
    """

    differences: tuple[CellDifference, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]

    @property
    def worse(self) -> bool:
        """Whether a cell of the second is significantly worse."""
        return any(each.worse for each in self.differences)


def compare(first: Sequence[Tally], second: Sequence[Tally]) -> ComparedCampaigns:
    """Return how the cells of two campaigns differ, matched by their names."""
    others = {each.cell.name: each for each in second}
    pairs = [(each, others[each.cell.name]) for each in first if each.cell.name in others]
    found = [_difference(a, b) for a, b in pairs]
    significant = _holm([each.chance for each in found])
    differences = tuple(
        replace(each, significant=number in significant) for number, each in enumerate(found)
    )
    names, both = {each.cell.name for each in first}, {each.name for each in differences}
    return ComparedCampaigns(
        differences,
        tuple(each.cell.name for each in first if each.cell.name not in both),
        tuple(name for name in others if name not in names),
    )


def _difference(first: Tally, second: Tally) -> CellDifference:
    """Return how two cells differ; whether it is significant depends on the others, too.

    Runs are compared in pairs if one cell has all the seeds of the other: one of them may have been
    stopped earlier.
    """
    before, after = _passes(first), _passes(second)
    lost = tuple(seed for seed, passed in before.items() if passed and not after.get(seed, True))
    gained = tuple(seed for seed, passed in after.items() if passed and not before.get(seed, True))
    passed, then = (first.passed, first.runs), (second.passed, second.runs)
    if len(before.keys() & after.keys()) == min(len(before), len(after)) > 0:
        chance = mcnemar_exact(len(lost), len(gained))
        return CellDifference(first.cell.name, passed, then, chance, "McNemar", lost, gained)
    chance = fisher_exact(*passed, *then)
    return CellDifference(first.cell.name, passed, then, chance, "Fisher", lost, gained)


def _passes(tally: Tally) -> dict[int, int]:
    """Return whether the runs that count have passed, by their seeds."""
    return dict(zip(tally.cell.seeds, tally.passes, strict=False))


def _holm(chances: Sequence[float]) -> set[int]:
    """Return the numbers of the chances that are significant together.

    Holm, "A simple sequentially rejective multiple test procedure", Scandinavian Journal of
    Statistics 6 (1979) 65-70.
    """
    found = set[int]()
    for rank, number in enumerate(sorted(range(len(chances)), key=lambda n: chances[n])):
        if chances[number] > LEVEL / (len(chances) - rank):
            break
        found.add(number)
    return found


def comparison_text(compared: ComparedCampaigns) -> str:
    """Return the comparison as lines for people."""
    return "\n".join(_lines(compared)) + "\n"


def _lines(compared: ComparedCampaigns) -> Iterator[str]:
    width = max((len(each.name) for each in compared.differences), default=0)
    yield f"{'':{width}}  {'A passed':>22}  {'B passed':>22}  by chance  test"
    for each in compared.differences:
        word = "" if not each.significant else "  WORSE" if each.worse else "  better"
        yield (
            f"{each.name:{width}}  {_share(each.passed):>22}  {_share(each.then):>22}"
            f"  {each.chance:9.2g}  {each.test:7}{word}".rstrip()
        )
        for what, seeds in (("lost", each.lost), ("gained", each.gained)):
            if seeds:
                shown = ", ".join(map(str, seeds[:_MOST_SEEDS]))
                more = ", …" if len(seeds) > _MOST_SEEDS else ""
                yield f"    {len(seeds):,} {what} in B: seeds {shown}{more}"
    for whose, names in (("A", compared.only_first), ("B", compared.only_second)):
        for name in names:
            yield f"{name}: only in {whose}"
    if not compared.differences:
        yield "no cell is in both"
    elif compared.worse:
        yield "B is worse than A"
    else:
        yield "B is not significantly worse than A"


def _share(passed: tuple[int, int]) -> str:
    count, runs = passed
    return f"{count:,} of {runs:,} {count / runs:6.1%}" if runs else "no runs"
