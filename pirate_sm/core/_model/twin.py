"""Numbers of one robot that its profile assumes and a recording of it has shown."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pirate_sm.core._model.base import Format, Frozen, Name
from pirate_sm.core._model.quantities import AngularSpeed, Stiffness, Torque
from pirate_sm.core._model.simulation import Friction


class MotorNumbers(Frozen):
    """Numbers of a kind of motor, instead of the profile's; what is left out stays.

    Attributes:
        no_load_speed: Speed at full duty without load.
        stall_torque: Torque at full duty at standstill.
        stiffness: Of the spring behind a worm.
        hold_torque: Torque that turns a geared motor against its gearbox at duty 0.
        dead_drag: Drag torque of a failed geared motor.
    """

    no_load_speed: Annotated[AngularSpeed, Field(gt=0)] | None = None
    stall_torque: Annotated[Torque, Field(gt=0)] | None = None
    stiffness: Annotated[Stiffness, Field(gt=0)] | None = None
    hold_torque: Annotated[Torque, Field(ge=0)] | None = None
    dead_drag: Annotated[Torque, Field(ge=0)] | None = None


class Twin(Frozen):
    """What a simulated robot has instead of its profile's numbers.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        motors: By kind of motor.
        joints: The same of the motor of one joint, instead of those of its kind.
        friction: Between wheel and wall, instead of the profile's.
    """

    format: Format
    robot: Name
    motors: dict[Name, MotorNumbers] = {}
    joints: dict[Name, MotorNumbers] = {}
    friction: Friction | None = None
