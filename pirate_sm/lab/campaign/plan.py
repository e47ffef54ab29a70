"""What a campaign is to run: its cells, each of them a run that is repeated with many seeds."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, PlainSerializer, PlainValidator, TypeAdapter, ValidationError
from pydantic_core import to_json, to_jsonable_python

import pirate_sm
from pirate_sm.core.documents import read_text
from pirate_sm.core.loading import LoadedMission, twin_named
from pirate_sm.core.models import LineFaults
from pirate_sm.core.on_disk import is_file
from pirate_sm.core.options import OPTIONS, written
from pirate_sm.core.units import DIMENSIONLESS, TIME
from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule, TrueEnd
from pirate_sm.lab.campaign.margins_model import MarginFactor, Margins
from pirate_sm.lab.campaign.sensitivity import Design
from pirate_sm.lab.campaign.sensitivity_model import Factor
from pirate_sm.lab.campaign.sequential import SequentialTest
from pirate_sm.running.wiring import Order

FORMAT = 1
"""Version of what is written of a plan."""


def _plain_seeds(seeds: Sequence[int]) -> dict[str, int] | list[int]:
    if isinstance(seeds, range):
        return {"from": seeds.start, "to": seeds.stop - 1}
    return list(seeds)


def _seeds(marked: Any) -> Sequence[int]:
    match marked:
        case {"from": int(first), "to": int(last)}:
            return range(first, last + 1)
        case [*listed] if all(isinstance(each, int) for each in listed):
            return tuple(listed)
    raise ValueError("neither the first and the last seed nor a list of seeds")


@dataclass(frozen=True)
class Cell:
    """A mission in a pipe with defects and parameters, to be run with many seeds.

    Attributes:
        row: Its mission as people call it; ``column``: what it is combined with, may be empty.
        order: What is run; the seed is replaced.
        seeds: The seeds in their order.
        end: What must be true when the mission has succeeded.
        expect: Least shares of its runs.
        key: Digest of all that its results depend on but the seed.
        mission: Key of its loaded mission in :attr:`CampaignPlan.missions`.
        design: How its runs vary the robot, which are counted where others have seeds; None: they
            do not.
        sampled: What its runs draw from the sample of a twin, whose file a report does not need.
        around: The factors that are changed round it, to see how far it holds.
    """

    row: str
    column: str
    order: Order
    seeds: Annotated[Sequence[int], PlainValidator(_seeds), PlainSerializer(_plain_seeds)]
    end: TrueEnd
    expect: Expectation
    key: str
    mission: str = ""
    design: Design | None = None
    sampled: tuple[Factor, ...] = ()
    around: tuple[MarginFactor, ...] = ()

    @property
    def name(self) -> str:
        """The name of the cell, which no other cell of its campaign has."""
        return f"{self.row}: {self.column}" if self.column else self.row

    @property
    def values(self) -> dict[str, str]:
        """What its runs have in common, by name; what is left open is not there."""
        order = self.order
        named = {"name": self.name, "mission": order.mission}
        for name, each in OPTIONS.items():
            value = getattr(order, name)
            if each.in_campaigns and value is not None and not each.key:
                named[each.word] = " + ".join(each.texts(value))
        named["line"] = ", ".join(_faults(order.line))
        named |= {f"set_{name}": value for name, value in order.settings.items()}
        return {name: value for name, value in named.items() if value}


@dataclass(frozen=True)
class CampaignPlan:
    """A campaign whose files have been read and checked.

    Attributes:
        name: Name of the campaign.
        version: Of the code that runs it.
        cells: Its cells, in the order of the file.
        confidence: Of all intervals.
        stop: When a cell has had enough runs.
        missions: The loaded missions, pickled, by key.
        margins: How far its cells are to hold; None: that is not asked.
    """

    name: Annotated[str, Field(alias="campaign")]
    version: str
    cells: tuple[Cell, ...]
    confidence: Annotated[float, Field(gt=0, lt=1)]
    stop: StoppingRule
    missions: Mapping[str, bytes] = field(default_factory=dict)
    margins: Margins | None = None

    @property
    def test(self) -> SequentialTest | None:
        """The test that ends a cell instead of the number of its seeds, if margins are asked."""
        return None if self.margins is None else self.margins.test(self.confidence)


_PLAN = TypeAdapter(CampaignPlan)
_UNMARKED: Any = {"missions": True, "cells": {"__all__": {"mission"}}}


def mark_of(plan: CampaignPlan) -> dict[str, Any]:
    """Return what a reader of results needs of a plan, as plain data."""
    mark = _PLAN.dump_python(plan, mode="json", by_alias=True, exclude=_UNMARKED)
    cells = [
        {**marked, "values": cell.values}
        for marked, cell in zip(mark["cells"], plan.cells, strict=True)
    ]
    return {"format": FORMAT, **mark, "cells": cells}


def plan_of(mark: Mapping[str, Any]) -> CampaignPlan:
    """Return the plan of a mark, without its missions: it cannot be run.

    Raises:
        ValueError: The mark is damaged; the text says what is wrong with it.
    """
    try:
        return _PLAN.validate_json(to_json(mark))
    except ValidationError as error:
        raise ValueError("; ".join(_faults_of(error))) from None


def _faults_of(error: ValidationError) -> Iterator[str]:
    """Yield what is wrong with a mark, with the place in it, at most three faults."""
    for each in error.errors(include_url=False)[:3]:
        place = ".".join(map(str, each["loc"]))
        missing = each["type"] == "missing"
        yield f"`{place}` is missing" if missing else f"`{place}`: {each['msg']}"


def varied(cell: Cell, seed: int, drawn: Mapping[str, float]) -> Order:
    """Return the order of a run, for which a sensitivity has drawn some numbers."""
    if cell.design is None:
        return replace(cell.order, seed=seed)
    numbers = cell.design.written(drawn)
    return replace(cell.order, seed=cell.design.seed(seed), numbers=numbers)


def command_of(order: Order, seed: int) -> str:
    """Return the command that repeats a run."""
    mission, *words = replace(order, seed=0, check=True).command()
    words += [word for fault in _faults(order.line) for word in ("--line", fault)]
    return f"pirate run {shlex.join([mission, '--seed', str(seed), '--speed', 'max', *words])}"


def _faults(line: LineFaults | None) -> Iterator[str]:
    """Yield the faults of a line that are switched on, with their values."""
    given = {} if line is None else line.model_dump(exclude_defaults=True)
    for name, value in given.items():
        is_share = name in ("loss_in", "loss_out", "corruption")
        text = written(value, DIMENSIONLESS if is_share else TIME)
        yield f"{name}={text.replace(' ', '')}"


# --- keys


def key_of(
    order: Order,
    loaded: LoadedMission,
    end: TrueEnd,
    design: Design | None,
    version: str | None = None,
) -> str:
    """Return a digest of all that the result of a run depends on but its seed.

    Files count by their content, not by their names, which may differ elsewhere. The version is
    that of this code, if no other one is given.
    """
    twin, _ = twin_named(order.twin or "", 0)
    which = (order.twin or "")[len(twin) :] or None
    rest = replace(order, mission="", pipe=None, robot=None, twin=which, seed=0)
    kind, _, camera = (order.detector or "").partition(":")
    named = [twin, camera if kind == "vision" else ""]
    parts = [
        version or code_version(),
        json.dumps(to_jsonable_python(rest), sort_keys=True),
        end.model_dump_json(),
        *([] if design is None else [design.digest]),
        *(document.text for document in loaded.documents),
        *(read_text(each, each, "a file") for each in named if each and is_file(each)),
    ]
    digest = sha256()
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()[:16]


# --- version of the code -------------------------------------------------------------------------


_DIGITS = 12


@cache
def code_version() -> str:
    """Return the version of the package with a digest of its Python files.

    Equal versions in different working copies may compute differently; their digests differ.
    """
    root = Path(pirate_sm.__file__).parent
    digest = sha256()
    for file in sorted(root.rglob("*.py")):
        digest.update(file.relative_to(root).as_posix().encode() + b"\0")
        digest.update(file.read_bytes() + b"\0")
    return f"{pirate_sm.__version__}+{digest.hexdigest()[:_DIGITS]}"
