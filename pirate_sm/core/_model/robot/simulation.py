"""Settings of a robot for simulators only: friction, noise, defects, and its twin's numbers.

A twin has the numbers that a profile assumes and a recording of the robot has shown.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import Field, ValidationError, model_validator

from pirate_sm.core._model.base import Format, Frozen, Name
from pirate_sm.core._model.quantities import (
    Acceleration,
    Angle,
    AngularSpeed,
    Current,
    Duration,
    Length,
    PositiveDuration,
    Ratio,
    Speed,
    Stiffness,
    Torque,
)
from pirate_sm.core._model.robot.defects import Defect


class Coefficients(Frozen):
    """Coefficients of Coulomb friction between wheel and wall.

    Attributes:
        static: Coefficient of static friction.
        kinetic: Coefficient of kinetic friction; at most ``static``.
    """

    static: Annotated[Ratio, Field(ge=0, le=5)]
    kinetic: Annotated[Ratio, Field(ge=0, le=5)]

    @model_validator(mode="after")
    def _static_holds_more(self) -> Self:
        if self.kinetic > self.static:
            raise ValueError("kinetic friction cannot be more than static friction")
        return self


class Friction(Coefficients):
    """Coulomb friction between wheel and wall.

    Attributes:
        threshold: Speed of the slip below which the static coefficient holds, on the backend
            physics (thesis, table 4-1).
    """

    threshold: Annotated[Speed, Field(gt=0)] = 0.001


class Tyre(Frozen):
    """How the tyre of a wheel rolls and spins on a wall.

    Attributes:
        rolling_resistance: Force that resists rolling, over the normal force. Tyres of cars have
            0.015 on concrete (Gillespie, Fundamentals of Vehicle Dynamics, chapter 4), rubber of
            small wheels somewhat more [assumed].
        spin_radius: Torque of friction against spinning on the spot, over the force of friction:
            3 pi / 16 of the radius of the contact (Hertz), which is 2.4 mm for a wheel of 24 mm
            that is pressed in by 0.25 mm [assumed]. Only the backend physics reads it.
    """

    rolling_resistance: Annotated[Ratio, Field(ge=0, le=0.2)] = 0.0
    spin_radius: Annotated[Length, Field(ge=0)] = 0.0014


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


class RulerSettings(Frozen):
    """A ruler outside the robot, which a run may switch on.

    Attributes:
        signal: The outside signal that it measures: the speed of the robot along the pipe.
        every: The time between two measurements.
        noise: Standard deviation of a measurement.
    """

    signal: Name
    every: PositiveDuration
    noise: Annotated[Speed, Field(ge=0)] = 0.0


SIMULATORS = frozenset({"physics", "sim"})
"""Backends that simulate a robot in a pipe, from a seed."""


class Simulation(Frozen):
    """Simulator settings of a robot.

    Attributes:
        friction: Between wheel and wall.
        tyre: Of every wheel.
        noise: On what the sensors see.
        ruler: A ruler outside the robot; ``--ruler`` switches it on.
        defects: Known defects by name; ``--defect`` switches one on.
    """

    friction: Friction
    tyre: Tyre = Tyre()
    noise: Noise = Noise()
    ruler: RulerSettings | None = None
    defects: dict[Name, Defect] = {}


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


PARTS_OF_A_TWIN: Mapping[str, type[Frozen]] = {
    "motors": MotorNumbers,
    "joints": MotorNumbers,
    "friction": Friction,
    "noise": Noise,
    "tyre": Tyre,
}
"""The numbers in each part of a twin; motors and joints have them by name."""


class RobotSample(Frozen):
    """Robots that are equally likely after a recording, instead of one.

    Attributes:
        numbers: What the columns are: a kind of motor and its number, ``wheel stall_torque``, or
            ``friction static``, ``friction kinetic`` and ``tyre rolling_resistance``.
        assumed: Those that the recording does not show: drawn around what the profile assumes.
        robots: A row for each robot, in SI units.
    """

    numbers: Annotated[tuple[str, ...], Field(min_length=1)]
    assumed: tuple[str, ...] = ()
    robots: Annotated[tuple[tuple[float, ...], ...], Field(min_length=1, max_length=10_000)]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        others = {"friction": {"static", "kinetic"}, "tyre": {"rolling_resistance"}}
        for name in self.numbers:
            owner, _, key = name.partition(" ")
            if key not in others.get(owner, MotorNumbers.model_fields):
                raise ValueError(f"'{name}' is not a number of a robot, such as wheel stall_torque")
        if len({*self.numbers}) < len(self.numbers):
            raise ValueError("`numbers` has a name twice")
        if unlisted := [name for name in self.assumed if name not in self.numbers]:
            raise ValueError(f"'{unlisted[0]}' is assumed and is none of the numbers")
        for number, row in enumerate(self.robots):
            if len(row) != len(self.numbers):
                raise ValueError(
                    f"robot {number} has {len(row)} numbers instead of {len(self.numbers)}"
                )
        return self


class Twin(Frozen):
    """What a simulated robot has instead of its profile's numbers.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        motors: By kind of motor.
        joints: The same of the motor of one joint, instead of those of its kind.
        friction: Between wheel and wall, instead of the profile's.
        sample: Robots that may all be this one; FILE#3 names one of them.
        noise: Of the sensors; what is left out stays.
        tyre: Of every wheel; what is left out stays.
    """

    format: Format
    robot: Name
    motors: dict[Name, MotorNumbers] = {}
    joints: dict[Name, MotorNumbers] = {}
    friction: Friction | None = None
    noise: Noise | None = None
    tyre: Tyre | None = None
    sample: RobotSample | None = None

    @model_validator(mode="after")
    def _each_robot_is_one(self) -> Self:
        for number in range(len(self.sample.robots) if self.sample is not None else 0):
            try:
                self.drawn(number)
            except ValidationError as error:
                fault = error.errors()[0]
                name = " ".join(str(key) for key in fault["loc"] if key != "motors")
                raise ValueError(f"robot {number} of the sample: {name}: {fault['msg']}") from None
        return self

    def drawn(self, number: int) -> Self:
        """Return a robot of the sample as a twin; after the last one comes the first again."""
        assert self.sample is not None
        given = self.model_dump(exclude_none=True, exclude={"sample", "noise", "tyre"})
        if self.tyre is not None:
            given["tyre"] = self.tyre.model_dump(exclude_unset=True)
        row = self.sample.robots[number % len(self.sample.robots)]
        for name, value in zip(self.sample.numbers, row, strict=True):
            owner, _, key = name.partition(" ")
            group = given if owner in {"friction", "tyre"} else given["motors"]
            group.setdefault(owner, {})[key] = value
        return type(self).model_validate(given).model_copy(update={"noise": self.noise})


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
