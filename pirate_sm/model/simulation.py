"""What only a simulator needs to know of a robot: friction, noise and the known defects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Acceleration, Angle, Current, Duration, Length, Number, Ratio


class Friction(Frozen):
    """Coulomb friction between wheel and wall."""

    static: Annotated[Number, Field(ge=0, le=5)]
    kinetic: Annotated[Number, Field(ge=0, le=5)]


class Noise(Frozen):
    """Standard deviations of seeded white noise on what the sensors see."""

    angle: Annotated[Angle, Field(ge=0)] = 0.0
    current: Annotated[Current, Field(ge=0)] = 0.0
    acceleration: Annotated[Acceleration, Field(ge=0)] = 0.0
    detector: Annotated[Length, Field(ge=0)] = 0.0


class Defect(Frozen):
    """A known defect that can be switched on by its name.

    Attributes:
        kind: What goes wrong.
        wheels: Wheels it acts on.
        joint: Joint it acts on.
        boards: Boards it acts on.
        after: How long after the start it begins.
        every: Mean time between two occurrences.
        lasting: How long one occurrence lasts.
        angle: Size of a jump or value of a stuck sensor.
        factor: Multiplier, of friction or noise.
        share: Share of messages concerned.
    """

    kind: Literal[
        "dead_wheel",
        "sensor_drop",
        "sensor_stuck",
        "sensor_spike",
        "zero_jump",
        "stiff_joint",
        "silent_bay",
        "lost_messages",
        "stale_repeats",
        "firmware_reset",
    ]
    description: str
    wheels: tuple[Name, ...] = ()
    joint: Name | None = None
    boards: tuple[int, ...] = ()
    after: Duration = 0.0
    every: Duration = 0.0
    lasting: Duration = 0.0
    angle: Angle | None = None
    factor: Annotated[Number, Field(gt=0)] = 1.0
    share: Annotated[Ratio, Field(ge=0, le=1)] = 0.0


class Simulation(Frozen):
    """Simulator settings of a robot."""

    friction: Friction
    noise: Noise = Noise()
    defects: dict[Name, Defect] = {}
