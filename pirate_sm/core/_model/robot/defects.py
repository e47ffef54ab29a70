"""The kinds of defects of a simulated robot, and a defect as its profile declares it."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field

from pirate_sm.core._model.base import AlsoWritten, Frozen, Name
from pirate_sm.core._model.quantities import Count, Duration, Number, Ratio, Torque
from pirate_sm.core.options import defect_as_text

Kind: TypeAlias = Literal[
    "dead_wheel",
    "stiff_joint",
    "sensor_stuck",
    "sensor_drop",
    "sensor_spike",
    "zero_jump",
    "silent_bay",
    "silent_boards",
    "lost_messages",
    "stale_repeats",
    "firmware_reset",
    "controller_reset",
    "controller_hang",
    "stray_motion",
]
"""The kinds of defects, which `simulation/defects.py` simulates."""


class Defect(Frozen):
    """A known defect, which can be switched on by its name.

    Attributes:
        kind: What goes wrong.
        description: One-line description.
        wheels: The affected wheels.
        joint: The affected joint.
        signals: The signals of the affected channels.
        raw: Raw counts that the affected channels show, or by which they jump.
        boards: The affected boards; all if empty.
        after: Time from the start of the run to its beginning.
        every: Mean time between two occurrences.
        lasting: How long one occurrence lasts.
        friction: Dry friction of a stiff joint, drag of a dead wheel.
        share: Share of lost messages.
    """

    kind: Kind
    description: str
    wheels: tuple[Name, ...] = ()
    joint: Name | None = None
    signals: tuple[Name, ...] = ()
    raw: dict[Name, Number] = {}
    boards: tuple[Count, ...] = ()
    after: Annotated[Duration, Field(ge=0)] = 0.0
    every: Annotated[Duration, Field(ge=0)] = 0.0
    lasting: Annotated[Duration, Field(ge=0)] = 0.0
    friction: Annotated[Torque, Field(ge=0)] = 0.0
    share: Annotated[Ratio, Field(ge=0, le=0.5)] = 0.0


_MAPPED = {
    "type": "object",
    "required": ["defect"],
    "additionalProperties": {"type": ["string", "number"]},
    "description": "A defect with numbers: {defect: NAME, after: 2 s}.",
}
DefectText: TypeAlias = Annotated[
    str, BeforeValidator(defect_as_text), AlsoWritten(lambda _: [_MAPPED])
]
"""A defect with its numbers, as :mod:`pirate_sm.core.options` explains."""
