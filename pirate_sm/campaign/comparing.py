"""Compares two campaigns cell by cell: which differences are more than chance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pirate_sm.campaign.intervals import fisher_exact
from pirate_sm.campaign.tally import Tally

LEVEL = 0.05
"""Chance at which one of all the differences found would be none."""

_MOST_SEEDS = 10


@dataclass(frozen=True)
class Difference:
    """What differs between two cells of one name.

    Attributes:
        name: Of the cells.
        passed: Passed runs and runs of the first; likewise ``then`` of the second.
        chance: How likely so large a difference is by chance, by Fisher's exact test, two-sided.
        significant: Whether it counts, with as many cells as were compared (Holm's correction).
        lost: Seeds that passed in the first and do not in the second; likewise ``gained``.
    """

    name: str
    passed: tuple[int, int]
    then: tuple[int, int]
    chance: float
    significant: bool
    lost: tuple[int, ...]
    gained: tuple[int, ...]

    @property
    def worse(self) -> bool:
        """Whether the second is significantly worse."""
        return self.significant and self.then[0] * self.passed[1] < self.passed[0] * self.then[1]


@dataclass(frozen=True)
class Compared:
    """Two campaigns.

    Attributes:
        differences: Of the cells that both have, in the order of the first.
        only_first: Names of cells of the first alone; likewise ``only_second``.
    """

    differences: tuple[Difference, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]

    @property
    def worse(self) -> bool:
        """Whether a cell of the second is significantly worse."""
        return any(each.worse for each in self.differences)


def compare(first: Sequence[Tally], second: Sequence[Tally]) -> Compared:
    """Return how the cells of two campaigns differ, matched by their names."""
    others = {each.cell.name: each for each in second}
    pairs = [(each, others[each.cell.name]) for each in first if each.cell.name in others]
    chances = [fisher_exact(a.passed, a.runs, b.passed, b.runs) for a, b in pairs]
    significant = _holm(chances)
    differences = tuple(
        Difference(
            a.cell.name,
            (a.passed, a.runs),
            (b.passed, b.runs),
            chance,
            number in significant,
            tuple(_changed(a, b)),
            tuple(_changed(b, a)),
        )
        for number, ((a, b), chance) in enumerate(zip(pairs, chances, strict=True))
    )
    names, both = {each.cell.name for each in first}, {each.name for each in differences}
    return Compared(
        differences,
        tuple(each.cell.name for each in first if each.cell.name not in both),
        tuple(name for name in others if name not in names),
    )


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


def _changed(passing: Tally, other: Tally) -> Iterator[int]:
    """Yield the seeds that pass in one tally and not in another that has them too."""
    failing = {
        seed for seed, passed in zip(other.cell.seeds, other.passes, strict=False) if not passed
    }
    if failing:
        for seed, passed in zip(passing.cell.seeds, passing.passes, strict=False):
            if passed and seed in failing:
                yield seed


def comparison_text(compared: Compared) -> str:
    """Return the comparison as lines for people."""
    return "\n".join(_lines(compared)) + "\n"


def _lines(compared: Compared) -> Iterator[str]:
    width = max((len(each.name) for each in compared.differences), default=0)
    yield f"{'':{width}}  {'A passed':>22}  {'B passed':>22}  by chance"
    for each in compared.differences:
        word = "" if not each.significant else "  WORSE" if each.worse else "  better"
        yield (
            f"{each.name:{width}}  {_share(each.passed):>22}  {_share(each.then):>22}"
            f"  {each.chance:9.2g}{word}"
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
