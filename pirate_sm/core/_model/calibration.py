"""The calibration of one robot: the readings of its joint sensors when it is straight."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from pirate_sm.core._model.base import Format, Frozen, Name
from pirate_sm.core._model.quantities import Angle

Date = Annotated[str, StringConstraints(pattern=r"^\d{4}-\d{2}-\d{2}$")]


class Calibration(Frozen):
    """The zeros of one robot's joints, measured on one day.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        date: Date of the measurement.
        port: Port of the robot.
        zeros: The reading of each joint's sensor when the joint is at zero; it is subtracted from
            each reading.
    """

    format: Format
    robot: Name
    date: Date
    port: str = ""
    zeros: Annotated[dict[Name, Angle], Field(min_length=1)]
