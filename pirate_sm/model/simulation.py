"""Settings of a robot for simulators only: friction, noise and known defects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import (
    Acceleration,
    Angle,
    Count,
    Current,
    Duration,
    Length,
    Number,
    Ratio,
    Torque,
)


class Friction(Frozen):
    """Coulomb friction between wheel and wall.

    Attributes:
        static: Coefficient of static friction.
        kinetic: Coefficient of kinetic friction; at most ``static``.
    """

    static: Annotated[Number, Field(ge=0, le=5)]
    kinetic: Annotated[Number, Field(ge=0, le=5)]

    @model_validator(mode="after")
    def _static_holds_more(self) -> Friction:
        if self.kinetic > self.static:
            raise ValueError("kinetic friction cannot be more than static friction")
        return self


class Noise(Frozen):
    """Standard deviations of the seeded white noise of the sensors.

    Attributes:
        angle: For joint and wheel angles.
        current: For motor currents.
        acceleration: For accelerometers.
        detector: For the position at which a simulated detector reports a word.
    """

    angle: Annotated[Angle, Field(ge=0)] = 0.0
    current: Annotated[Current, Field(ge=0)] = 0.0
    acceleration: Annotated[Acceleration, Field(ge=0)] = 0.0
    detector: Annotated[Length, Field(ge=0)] = 0.0


Kind = Literal[
    "dead_wheel",
    "stiff_joint",
    "sensor_stuck",
    "sensor_drop",
    "sensor_spike",
    "zero_jump",
    "silent_bay",
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


class Simulation(Frozen):
    """Simulator settings of a robot.

    Attributes:
        friction: Friction between wheel and wall.
        noise: Noise of the sensors.
        defects: Known defects by name, which ``--defect`` switches on.
    """

    friction: Friction
    noise: Noise = Noise()
    defects: dict[Name, Defect] = {}
