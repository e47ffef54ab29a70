"""What a campaign is to run: its cells, each of them a run that is repeated with many seeds."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic_core import to_jsonable_python

from pirate_sm.model.campaign import Expectation, StoppingRule, TrueEnd
from pirate_sm.model.fidelity import USUAL
from pirate_sm.model.variations import LineFaults
from pirate_sm.wiring import Order

FORMAT = 1
"""Version of what is written of a plan."""


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
        mission: Key of its loaded mission in :attr:`Plan.missions`.
    """

    row: str
    column: str
    order: Order
    seeds: Sequence[int]
    end: TrueEnd
    expect: Expectation
    key: str
    mission: str

    @property
    def name(self) -> str:
        """The name of the cell, which no other cell of its campaign has."""
        return f"{self.row}: {self.column}" if self.column else self.row


@dataclass(frozen=True)
class Plan:
    """A campaign whose files have been read and checked.

    Attributes:
        name: Name of the campaign.
        version: Of the code that runs it.
        cells: Its cells, in the order of the file.
        confidence: Of all intervals.
        stop: When a cell has had enough runs.
        missions: The loaded missions, pickled, by key.
    """

    name: str
    version: str
    cells: tuple[Cell, ...]
    confidence: float
    stop: StoppingRule
    missions: Mapping[str, bytes]


def mark_of(plan: Plan) -> dict[str, Any]:
    """Return what a reader of results needs of a plan, as plain data."""
    cells = [
        {
            "row": cell.row,
            "column": cell.column,
            "key": cell.key,
            "seeds": _plain_seeds(cell.seeds),
            "order": to_jsonable_python(cell.order),
            "end": cell.end.model_dump(),
            "expect": cell.expect.model_dump(),
        }
        for cell in plan.cells
    ]
    return {
        "format": FORMAT,
        "campaign": plan.name,
        "version": plan.version,
        "confidence": plan.confidence,
        "stop": plan.stop.model_dump(),
        "cells": cells,
    }


def plan_of(mark: Mapping[str, Any]) -> Plan:
    """Return the plan of a mark, without its missions: it cannot be run.

    Raises:
        KeyError: Something is missing in the mark; likewise TypeError and ValueError.
    """
    if mark["format"] != FORMAT:
        raise ValueError(f"expected format {FORMAT}, got {mark['format']!r}")
    cells = [
        Cell(
            each["row"],
            each["column"],
            _order(each["order"]),
            _seeds(each["seeds"]),
            TrueEnd(**each["end"]),
            Expectation(**each["expect"]),
            each["key"],
            "",
        )
        for each in mark["cells"]
    ]
    stop = StoppingRule(**mark["stop"])
    return Plan(mark["campaign"], mark["version"], tuple(cells), mark["confidence"], stop, {})


def _plain_seeds(seeds: Sequence[int]) -> dict[str, int] | list[int]:
    if isinstance(seeds, range):
        return {"from": seeds.start, "to": seeds.stop - 1}
    return list(seeds)


def _seeds(plain: dict[str, int] | list[int]) -> Sequence[int]:
    if isinstance(plain, dict):
        return range(plain["from"], plain["to"] + 1)
    return tuple(plain)


def _order(plain: dict[str, Any]) -> Order:
    line = plain["line"]
    several = {"defects": tuple(plain["defects"]), "firings": (), "course": ()}
    return Order(**{**plain, **several, "line": None if line is None else LineFaults(**line)})


def command_of(order: Order, seed: int) -> str:
    """Return the command that repeats a run."""
    words = [order.mission, "--seed", str(seed), "--speed", "max"]
    words += _option("--backend", order.backend, "sim")
    words += _option("--robot", order.robot, None) + _option("--pipe", order.pipe, None)
    for name, value in order.settings.items():
        words += ["--set", f"{name}={value}"]
    for defect in order.defects:
        words += ["--defect", defect]
    jitters = {
        "start": _length(order.start_jitter_m),
        "friction": _share(order.friction_jitter),
        "diameter": _length(order.diameter_jitter_m),
    }
    for name, value in jitters.items():
        words += ["--jitter", f"{name}={value}"] if value else []
    words += _option("--detector", order.detector, None) + _option("--twin", order.twin, None)
    words += _option("--fidelity", order.fidelity, USUAL)
    for name, value in _faults(order.line):
        words += ["--line", f"{name}={value}"]
    return f"pirate run {shlex.join(words)}"


def _option(name: str, value: str | None, usual: str | None) -> list[str]:
    return [] if value is None or value == usual else [name, value]


def _length(length_m: float) -> str:
    return f"{length_m * 1000:.12g}mm" if length_m else ""


def _share(share: float) -> str:
    return f"{share * 100:.12g}%" if share else ""


def _faults(line: LineFaults | None) -> list[tuple[str, str]]:
    """Return the faults of a line that are switched on, with their values as text."""
    given = {} if line is None else line.model_dump(exclude_defaults=True)
    shares = ("loss_in", "loss_out", "corruption")
    return [
        (name, _share(value) if name in shares else f"{value * 1000:.12g}ms")
        for name, value in given.items()
    ]
