"""How a run may differ from what the files of the robot and the pipe say."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pirate_sm.model.base import Frozen
from pirate_sm.model.quantities import Duration, Length, Ratio


class StartJitter(Frozen):
    """How far each run may differ from the files; drawn uniformly within plus and minus.

    Attributes:
        start: Of the robot's place along the pipe.
        friction: Of all friction coefficients, as a share.
        diameter: Of all inner diameters.
    """

    start: Annotated[Length, Field(ge=0)] = 0.0
    friction: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0
    diameter: Annotated[Length, Field(ge=0)] = 0.0


class LineFaults(Frozen):
    """Faults of the serial line and of the controller, for the backend ``bay``.

    Attributes:
        loss_in: Share of frames lost on their way to the robot.
        loss_out: Share of frames lost on their way back.
        corruption: Share of bytes changed, in either direction.
        delay: Added to every frame.
        jitter: Up to this much more, drawn for each frame.
        reset_every: Mean time between restarts of the controller.
        cut_after: When the line is cut for good, after the start of the controller; 0 for never.
    """

    loss_in: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    loss_out: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    corruption: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    delay: Annotated[Duration, Field(ge=0)] = 0.0
    jitter: Annotated[Duration, Field(ge=0)] = 0.0
    reset_every: Annotated[Duration, Field(ge=0)] = 0.0
    cut_after: Annotated[Duration, Field(ge=0)] = 0.0
