"""Controls: other ways to actuate a robot's states, which a mission chooses by name."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pirate_sm.core._model.actuation import Stages
from pirate_sm.core._model.base import Frozen, Name
from pirate_sm.core._model.quantities import Duration, Flag, Number, Torque
from pirate_sm.core._model.quantities import Speed as SlipSpeed


class Grip(Frozen):
    """How hard clamped parts press, from tilt, weight and friction (thesis eq. 3-16 to 3-25).

    It sets the torques that the control gives to the apexes of parts; their signs stay.

    Attributes:
        safety: How many times the weight the friction could bear.
        friction: Coefficient of friction for each part, or ``estimate``: what slipping wheels have
            shown, and the largest torque until then.
        share: How the torque is divided: ``as_printed`` takes what eq. 3-25 asks of the apex;
            ``corrected`` twice as much, since the outer wheels get only half of it.
        at_least: Smallest torque.
        at_most: The largest; by default what the apex's motor bears at the limit of its loop.
        alarm: Slip speed of a wheel from which on its part presses as hard as it may.
        lower_within: How long it takes to lower the torque from the largest to zero.
    """

    safety: Annotated[Number, Field(ge=1)]
    friction: Literal["estimate"] | dict[Name, Annotated[Number, Field(gt=0, le=5)]]
    share: Literal["as_printed", "corrected"] = "corrected"
    at_least: Annotated[Torque, Field(ge=0)] = 0.0
    at_most: Annotated[Torque, Field(gt=0)] | None = None
    alarm: Annotated[SlipSpeed, Field(gt=0)] = 0.010
    lower_within: Annotated[Duration, Field(gt=0)] = 10.0

    @model_validator(mode="after")
    def _has_room(self) -> Grip:
        if self.at_most is not None and self.at_least > self.at_most:
            raise ValueError("`at_least` cannot be more than `at_most`")
        return self


class Control(Frozen):
    """An overlay of ``actuation``: how some states drive their motors under this control.

    Attributes:
        description: One line for people.
        extends: The control that this one changes; by default the profile's ``actuation``.
        actuation: For some regions and states, what the slots get instead: duty cycles, speeds and
            torques. A state keeps its slots, its number of stages and the wheels that it drives.
        gravity_compensation: Whether wheels that are kept at a speed or a torque also bear their
            share of the weight (thesis eq. 3-13).
        grip: How hard clamped parts press; without it as hard as ``actuation`` says.
    """

    description: str = ""
    extends: Name | None = None
    actuation: dict[Name, dict[Name, Stages]] = {}
    gravity_compensation: Flag | None = None
    grip: Grip | None = None
