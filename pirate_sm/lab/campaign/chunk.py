"""A chunk of runs of one cell: what a Dask worker is sent, does, and sends back.

Each run draws from its seed how far it differs from its files.
"""

from __future__ import annotations

import pickle
import traceback
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import nan
from pathlib import Path
from time import monotonic, perf_counter
from typing import NamedTuple

import numpy as np

from pirate_sm.core.documents import LoadError, parse_document, read_document
from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.core.loading import LoadedMission, twin_named, validate
from pirate_sm.core.models import Profile, Twin
from pirate_sm.core.options import JITTER
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, parse_quantity, unit_of
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.plan import code_version
from pirate_sm.lab.campaign.sensitivity_model import Factor
from pirate_sm.lab.campaign.watched_run import (
    SHORT_M,
    Outcome,
    RunVerdict,
    finished,
    judge,
    watched_run,
)
from pirate_sm.running.runtime.near_misses import NearMisses
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.simulation.defects import drawn
from pirate_sm.simulation.surroundings import Jitter, drawn_jitter

# --- factors -------------------------------------------------------------------------------------


FROM_FILES = tuple(f"{each.key}_m" if each.unit == LENGTH else each.key for each in JITTER)
"""The factors that are how far a run differs from its files."""


_UNITS = {
    "no_load_speed": "rad/s",
    **dict.fromkeys(("stall_torque", "hold_torque", "dead_drag"), "Nm"),
    **{"stiffness": "Nm/rad", "static": "", "kinetic": ""},
}
"""The SI units of the numbers of a twin."""


def factors_of(order: Order) -> tuple[Factor, ...]:
    """Return what the runs of an order draw, but for the sample of a twin."""
    found = [
        Factor(name, unit_of(each.unit or DIMENSIONLESS), -most, most)
        for name, each in zip(FROM_FILES, JITTER, strict=True)
        if (most := getattr(order, each.name))
    ]
    for name, written in _numbers(order.defects):
        low, dots, high = map(str.strip, written.partition(".."))
        if dots and low != high:
            least, most = parse_quantity(low), parse_quantity(high).value
            found.append(Factor(name, unit_of(least.dimension), least.value, most))
    return tuple(found)


def sampled_factors(order: Order) -> tuple[Factor, ...]:
    """Return what the runs of an order draw from the sample of a twin."""
    return tuple(
        Factor(name.replace(" ", "_"), _UNITS[name.partition(" ")[2]], min(column), max(column))
        for name, column in _sampled(order).items()
        if min(column) < max(column)
    )


def _sampled(order: Order) -> Mapping[str, tuple[float, ...]]:
    """Return the columns of the sample from which each run draws its robot; of no sample none."""
    if not (order.twin or "").endswith("#seed"):
        return {}
    file, _ = twin_named(order.twin or "", order.seed)
    return _columns(read_document(Path(file)).text, file)


@lru_cache(maxsize=4)
def _columns(text: str, file: str) -> Mapping[str, tuple[float, ...]]:
    """Return the columns of the sample in the text of a twin, once for all runs of a cell."""
    sample = validate(parse_document(text, file), Twin).sample
    if sample is None:
        return {}
    return dict(zip(sample.numbers, zip(*sample.robots, strict=True), strict=True))


def drawn_factors(order: Order, profile: Profile) -> Mapping[str, float]:
    """Return what the run of an order, with its seed, draws: each factor in SI units.

    Raises:
        UsageError: The robot does not have the defects.
    """
    differs = drawn_jitter(Jitter(**order.jitter), np.random.default_rng(order.seed))
    numbers = dict(_numbers(drawn(order.defects, profile, order.seed)))
    values = {name: parse_quantity(text).value for name, text in numbers.items()}
    values |= zip(FROM_FILES, (differs.start_m, differs.friction, differs.diameter_m), strict=True)
    values |= {
        name.replace(" ", "_"): column[order.seed % len(column)]
        for name, column in _sampled(order).items()
    }
    found = {each.name: values[each.name] for each in (*factors_of(order), *sampled_factors(order))}
    return found | {name: parse_quantity(text).value for name, text in order.numbers.items()}


def _numbers(defects: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each number in the texts of defects, as it is written, by a name of its own."""
    for text in defects:
        defect, _, rest = text.partition(":")
        for pair in filter(None, rest.split(",")):
            key, _, written = pair.partition("=")
            yield f"{defect}_{key.strip()}", written.strip()


# --- chunks --------------------------------------------------------------------------------------


CHUNK = 20
"""Runs of a chunk: Dask takes some 10 ms of the client's processor for a task of any length."""

_LONGEST_S = 2.0
"""A chunk that takes longer is given back with the runs that are done, so that they are counted."""

_MOST_LOADED = 16
"""The most loaded missions that a worker keeps."""


class OtherVersionError(Exception):
    """Raised on a worker whose code is not that of the client."""


class RunRow(NamedTuple):
    """The result of one run.

    Attributes:
        cell: Key of its cell.
        outcome: As the mission says; ``bug``: this program raised an exception.
        verdict: What it was in truth, see :class:`pirate_sm.lab.campaign.watched_run.RunVerdict`.
        why: Why it did not pass; empty if it did.
        held: Whether it passed, or failed with the robot held.
        unsafe: The rules of safety that it broke; empty for none.
        short_m: How far a wheel was short of where the last word says; NaN if none was said.
        deepest_m: How deep a wheel or link was in a wall, at most; NaN if unknown.
        drawn: What it has drawn from its seed, see :mod:`pirate_sm.lab.campaign.chunk`.
        slip_m: How much farther its wheels have rolled than it has moved; NaN if unknown.
        near: How near it came to its limits, more is nearer; NaN if that was not looked at.
    """

    cell: str
    seed: int
    outcome: str
    verdict: str
    why: str
    held: bool
    unsafe: str
    time_s: float
    distance_m: float
    short_m: float
    deepest_m: float
    drawn: Mapping[str, float] = {}
    slip_m: float = nan
    near: float = nan


class Sent(NamedTuple):
    """A loaded mission on its way to the workers.

    Attributes:
        key: Digest of it.
        pickled: The mission.
    """

    key: str
    pickled: bytes


@dataclass(frozen=True)
class Chunk:
    """Runs of one cell with some of its seeds.

    Attributes:
        cell: Key of the cell.
        order: What is run.
        end: What must be true when the mission has succeeded.
        mission: Key of its loaded mission.
        seeds: The seeds; the numbers of the runs if these vary the robot.
        varied: The seed of each of these runs, and its numbers.
        near: Whether to look how near each comes to its limits, which takes longer.
    """

    cell: str
    order: Order
    end: TrueEnd
    mission: str
    seeds: tuple[int, ...]
    varied: Mapping[int, Order] = field(default_factory=dict)
    near: bool = False

    def order_of(self, seed: int) -> Order:
        """Return the order of a run."""
        return self.varied.get(seed) or replace(self.order, seed=seed)


_loaded: OrderedDict[str, LoadedMission] = OrderedDict()


def run_chunk(chunk: Chunk, sent: Sent, version: str) -> list[RunRow]:
    """Run a chunk on this worker; return a row for each of its first seeds, in their order.

    These are all, unless the runs are so long that the others should be a chunk of their own.

    Args:
        chunk: The runs.
        sent: Their mission; a process unpickles it once.
        version: Version of the client's code.

    Raises:
        OtherVersionError: This worker's code is another one.
    """
    if version != code_version():
        raise OtherVersionError(code_version())
    loaded = loaded_mission(sent)
    rows, began_s = list[RunRow](), monotonic()
    for seed in chunk.seeds:
        rows.append(run_seed(chunk, loaded, seed))
        if monotonic() - began_s >= _LONGEST_S:
            break
    return rows


def loaded_mission(sent: Sent) -> LoadedMission:
    """Return a mission that was sent; this process keeps the last ones."""
    if sent.key not in _loaded:
        _loaded[sent.key] = pickle.loads(sent.pickled)
        if len(_loaded) > _MOST_LOADED:
            _loaded.popitem(last=False)
    _loaded.move_to_end(sent.key)
    return _loaded[sent.key]


def run_seed(chunk: Chunk, loaded: LoadedMission, seed: int) -> RunRow:
    """Run a mission with one seed; whatever exception it raises is its outcome."""
    order, drawn = chunk.order_of(seed), dict[str, float]()
    try:
        drawn |= drawn_factors(order, loaded.loaded_robot.profile)
        if chunk.near:
            near, outcome = _near_run(order, loaded)
        else:
            near, outcome = nan, watched_run(order, loaded, slides=False)
    except (UsageError, LoadError, BackendError) as error:
        refused = RunVerdict("failed", str(error), False, "")
        return _without_end(chunk.cell, seed, "refused", refused, drawn)
    except Exception as error:
        return bug_row(chunk.cell, seed, _described(error), drawn)
    verdict = judge(outcome, chunk.end)
    return RunRow(
        chunk.cell,
        seed,
        outcome.outcome,
        *verdict,
        outcome.time_s,
        outcome.distance_m,
        outcome.short_m,
        outcome.deepest_m,
        drawn,
        outcome.slip_m if chunk.varied else nan,  # else a row would take 8 bytes more
        near,
    )


_POWER = 4
"""So the nearest limit counts most, and the others a little [decided]."""


def _near_run(order: Order, loaded: LoadedMission) -> tuple[float, Outcome]:
    """Return how near a run came to its limits, and what came of it.

    Each limit of the mission and of the robot's rules counts by the share of it that was reached,
    and so does the distance at which a success would be false.
    """
    limits = NearMisses(loaded.robot, loaded.program)
    outcome = finished(
        prepare(order, loaded),
        perf_counter(),
        slides=False,
        tap=limits,
        begun=lambda run: limits.follow(lambda: run.state),
    )
    shares = [each.share for each in limits.nearest()]
    if outcome.short_m > 0.0:
        shares.append(outcome.short_m / SHORT_M)
    return sum(share**_POWER for share in shares), outcome


def bug_row(cell: str, seed: int, why: str, drawn: Mapping[str, float]) -> RunRow:
    """Return the result of a run that an internal error has ended."""
    verdict = RunVerdict("bug", why, False, "did not end by itself")
    return _without_end(cell, seed, "bug", verdict, drawn)


def _without_end(
    cell: str, seed: int, outcome: str, verdict: RunVerdict, drawn: Mapping[str, float]
) -> RunRow:
    return RunRow(cell, seed, outcome, *verdict, 0.0, 0.0, nan, nan, drawn)


def _described(error: Exception) -> str:
    """Return an exception with the place in our code that it comes from."""
    text = f"{type(error).__name__}: {error}"
    frames = traceback.extract_tb(error.__traceback__)
    return f"{text} ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else text


def cut(chunk: Chunk, seeds: Sequence[int]) -> Chunk:
    """Return the part of a chunk that has these seeds."""
    return replace(chunk, seeds=tuple(seeds))
