"""What repeating an experiment gives: values by their names, figures, and notes for people."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from pirate_sm.views.drawing.svg.plot import Plot

Watch = Callable[[float], None]
"""Receives the share of the work that is done, from 0 to 1."""


@dataclass
class ExperimentResult:
    """What came of it.

    Attributes:
        values: Ours by name, SI units; rows of the thesis refer to them.
        figures: Those of the thesis, with our curves.
        notes: Lines for people.
    """

    values: dict[str, float] = field(default_factory=dict)
    figures: list[Plot] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
