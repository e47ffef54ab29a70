"""Draws what the runs of a sensitivity vary, and finds which of it decides; SALib does both.

Runs of a point that differ in the robot alone share the seed of all noise: their difference is an
effect of the numbers. The second sample of Sobol's estimator, which must be independent of the
first, has noise of its own, else what a number does together with the noise would count as what it
does alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from math import isfinite
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.lab.campaign.sensitivity_model import Factor

_SEED = 1
"""Of the points and of the resamples of intervals."""

_DIGITS = 6
"""Significant digits of a number that is drawn, as the command that repeats its run has it."""

_LEAST = 4
"""Of fewer points nothing is said."""

_LEAST_SHARE = 0.95
"""Likewise of a smaller share of the points: the estimators take all of a design, and those that
are left are chosen by what has come out. [decided]"""


@dataclass(frozen=True)
class Design:
    """How the runs of a cell vary the robot.

    Attributes:
        method: Of Sobol or of Morris.
        points: Points of Sobol's sequence, or Morris's paths.
        numbers: What is drawn.
    """

    method: Literal["sobol", "morris"]
    points: int
    numbers: tuple[Factor, ...]

    @property
    def block(self) -> int:
        """How many runs belong to a point."""
        return len(self.numbers) + (2 if self.method == "sobol" else 1)

    @property
    def runs(self) -> int:
        """How many runs there are."""
        return self.points * self.block

    def seed(self, run: int) -> int:
        """Return the seed of a run, which is counted from 0.

        The last run of a point of Sobol's is of the second sample alone (Saltelli et al. 2010,
        "Variance based sensitivity analysis of model output", Computer Physics Communications 181).
        """
        point, place = divmod(run, self.block)
        return 2 * point + (place == self.block - 1) if self.method == "sobol" else point

    def drawn(self, run: int) -> dict[str, float]:
        """Return the numbers of a run, which is counted from 0.

        Raises:
            UsageError: SALib is not installed.
        """
        row = _points(self)[run].tolist()
        return {each.name: value for each, value in zip(self.numbers, row, strict=True)}

    def written(self, drawn: Mapping[str, float]) -> dict[str, str]:
        """Return the numbers of a run as people write them."""
        return {
            each.name: f"{drawn[each.name]:.{_DIGITS}g} {each.unit}".strip()
            for each in self.numbers
            if each.name in drawn  # nothing is known of a run that lost its worker
        }

    @property
    def digest(self) -> str:
        """What says which points these are; other versions of a library may draw others.

        Raises:
            UsageError: SALib is not installed.
        """
        return repr(self) + sha256(_points(self).tobytes()).hexdigest()


def _salib(what: Literal["sample", "analyze"], method: str) -> Any:
    """Return a module of SALib.

    Raises:
        UsageError: It is not installed.
    """
    from importlib import import_module

    try:
        return import_module(f"SALib.{what}.{method}")
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "SALib":
            raise
        raise not_installed("a sensitivity", "SALib", "sensitivity") from None


def _problem(design: Design) -> dict[str, Any]:
    return {
        "num_vars": len(design.numbers),
        "names": [each.name for each in design.numbers],
        "bounds": [[each.low, each.high] for each in design.numbers],
    }


@lru_cache(maxsize=4)
def _points(design: Design) -> NDArray[np.float64]:
    """Return the numbers of each run, in rows."""
    sample = _salib("sample", design.method).sample
    more = {"calc_second_order": False} if design.method == "sobol" else {}
    points: NDArray[np.float64] = sample(_problem(design), design.points, seed=_SEED, **more)
    return points


# --- what decides --------------------------------------------------------------------------------


class RunOutcome(NamedTuple):
    """The outcome of a run, as far as numbers of the robot can decide it.

    Attributes:
        success: Whether it passed, 1 or 0; NaN if it was refused or met an internal error.
        time: Mission time, s.
        slip: How much farther its wheels have rolled than it has moved, m; NaN if unknown.
    """

    success: float
    time: float
    slip: float


Unit: TypeAlias = Literal["", "s", "m"]
_UNITS: tuple[Unit, ...] = ("", "s", "m")

_HALF_WIDTH = "_half_width"
_INDICES = {
    "sobol": {
        "total": "ST",
        "total_half_width": "ST_conf",
        "first": "S1",
        "first_half_width": "S1_conf",
    },
    "morris": {
        "mu_star": "mu_star",
        "mu_star_half_width": "mu_star_conf",
        "mu": "mu",
        "sigma": "sigma",
    },
}
"""The names of indices, by ours; the first says how much a number decides."""


@dataclass(frozen=True)
class NumberEffect:
    """How much a number decides.

    Attributes:
        name: Of the number.
        correlation: With the outcome, from -1 to 1.
        indices: Of Sobol: ``total`` and ``first``, as shares of the variance. Of Morris:
            ``mu_star``, ``mu`` and ``sigma``, in the unit of the outcome for the whole range of the
            number. Intervals have half a width.
    """

    name: str
    correlation: float
    indices: Mapping[str, float]

    @property
    def size(self) -> tuple[float, float]:
        """How much it decides, and half the width of the interval of that."""
        size, half_width, *_ = self.indices.values()
        return size, half_width

    @property
    def words(self) -> str:
        """Its indices and correlation, human-readable."""
        shown = []
        for name, value in self.indices.items():
            if not name.endswith(_HALF_WIDTH):
                half_width = self.indices.get(name + _HALF_WIDTH)
                more = "" if half_width is None else f" ± {half_width:.2g}"
                shown.append(f"{name.replace('_', ' ')} {value:.3g}{more}")
        return ", ".join((*shown, f"correlation {self.correlation:+.2f}"))


@dataclass(frozen=True)
class Decided:
    """What decides an outcome.

    Attributes:
        outcome: Its name; ``unit`` is empty for a share.
        method: Of Sobol or of Morris.
        points: How many points count: for time and slip those whose runs all passed.
        of: How many points were run.
        left_out: How many points never count: a run was refused or met an internal error.
        counted: The share of the points that count.
        numbers: What was varied, first what decides most; empty if all runs come to the same, or
            too few points count.
    """

    outcome: str
    unit: Unit
    method: Literal["sobol", "morris"]
    points: int
    of: int
    left_out: int
    counted: float
    numbers: tuple[NumberEffect, ...]

    @property
    def summary(self) -> str:
        """Which points count, and what the numbers are."""
        which = f"{self.points} of {self.of} points count"
        if self.left_out:
            which += f" ({self.left_out} left out: a run was refused or met an internal error)"
        if self.counted < _LEAST_SHARE:
            return f"{which}, fewer than {_LEAST_SHARE:.0%}: the rest is not a sample"
        if not self.numbers:
            return f"{which}, too few or all alike: nothing decides it here"
        if self.method == "sobol":
            return f"{which}; total has what a number does together with others and with the noise"
        return f"{which}, in {self.unit}" if self.unit else which


def decided(
    design: Design, runs: Sequence[tuple[RunOutcome, Sequence[float]]], share: float
) -> tuple[Decided, ...]:
    """Return what decides each outcome.

    Args:
        design: How the runs were varied.
        runs: The outcomes of the first runs and the numbers of each, in order.
        share: The confidence of intervals.

    Raises:
        UsageError: SALib is not installed.
    """
    points = len(runs) // design.block
    whole = runs[: points * design.block]
    x = np.array([drawn for _, drawn in whole]).reshape(points, design.block, -1)
    y = np.array([outcome for outcome, _ in whole]).reshape(points, design.block, -1)
    known = np.isfinite(x).all(axis=(1, 2)) & np.isfinite(y[:, :, 0]).all(axis=1)
    passed = known & (y[:, :, 0] == 1.0).all(axis=1)
    left_out, found = points - int(known.sum()), []
    for number, (name, unit) in enumerate(zip(RunOutcome._fields, _UNITS, strict=True)):
        counts = np.isfinite(y[:, :, number]).all(axis=1) & (passed if number else known)
        share_counted = float(counts.mean()) if points else 0.0
        of_runs = x[counts].reshape(-1, len(design.numbers)), y[counts][:, :, number].ravel()
        enough = share_counted >= _LEAST_SHARE
        effects = sorted(
            _effects(design, *of_runs, share) if enough else (), key=lambda each: -each.size[0]
        )
        counted = int(counts.sum()), points, left_out, share_counted
        found.append(Decided(name, unit, design.method, *counted, tuple(effects)))
    return tuple(found)


def decided_or_why(
    design: Design | None, runs: Sequence[tuple[RunOutcome, Sequence[float]]], share: float
) -> tuple[tuple[Decided, ...], str]:
    """Return what decides each outcome, and why that is not known, as :func:`decided`."""
    try:
        return (decided(design, runs, share) if design else ()), ""
    except UsageError as error:
        return (), str(error)


def _effects(
    design: Design, x: NDArray[np.float64], y: NDArray[np.float64], share: float
) -> Iterator[NumberEffect]:
    """Yield how much each number decides."""
    if len(y) < _LEAST * design.block or np.ptp(y) == 0.0:
        return
    module, more = _salib("analyze", design.method), {"conf_level": share, "seed": _SEED}
    with np.errstate(all="ignore"):  # some resamples may have runs of one outcome only
        if design.method == "sobol":
            indices = module.analyze(_problem(design), y, calc_second_order=False, **more)
        else:
            indices = module.analyze(_problem(design), x, y, **more)
        for number, each in enumerate(design.numbers):
            known = {
                ours: float(indices[theirs][number])
                for ours, theirs in _INDICES[design.method].items()
            }
            correlation = float(np.corrcoef(x[:, number], y)[0, 1])
            if all(map(isfinite, (correlation, *known.values()))):
                yield NumberEffect(each.name, correlation, known)
