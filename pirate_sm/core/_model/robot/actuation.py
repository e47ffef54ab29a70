"""Setpoints of states and postures, and controls, which are other ways to actuate states."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, PlainSerializer, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from pirate_sm.core._model.base import AlsoWritten, Condition, Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    Flag,
    Number,
    PositiveDuration,
    Torque,
    written,
    written_ratio,
)
from pirate_sm.core._model.quantities import Speed as SlipSpeed
from pirate_sm.core._model.robot.done_criteria import Criterion
from pirate_sm.core.units import ANGLE, DIMENSIONLESS, SPEED, TORQUE, QuantityError, parse_quantity


class Duty(NamedTuple):
    """A duty cycle, -1..1."""

    value: float


class Target(NamedTuple):
    """A target angle in rad."""

    angle_rad: float


class Share(NamedTuple):
    """A target angle as a multiple of the measured angle of a joint."""

    factor: float
    joint: str


class Level(NamedTuple):
    """A target angle in rad of the plane of the part that turns, against the horizontal."""

    angle_rad: float


class Speed(NamedTuple):
    """A speed in m/s at which a wheel rolls until another state writes its slot."""

    value: float


class HeldTorque(NamedTuple):
    """A torque in Nm that a joint or a wheel bears until another state writes its slot."""

    value: float


KEEP: Literal["keep"] = "keep"

Setpoint: TypeAlias = Duty | Target | Share | Level | Speed | HeldTorque | Literal["keep"]

_SHARE = r"^\s*([+-]?(?:\d+\.?\d*|\.\d+))\s*\*\s*([A-Za-z][A-Za-z0-9_]*)\s*$"


_EXPECTED = (
    "expected a duty cycle such as '60 %', an angle such as '-45 deg', a share of a joint's"
    " angle such as '-0.5 * elbow', an angle against the horizontal such as {{level: 0 deg}}, a"
    " speed such as '90 mm/s', a torque such as '350 mNm', or keep, got '{}'"
)


def _read(value: Any) -> Any:
    if isinstance(value, (Duty, Target, Share, Level, Speed, HeldTorque)) or value == KEEP:
        return value
    if isinstance(value, dict) and list(value) == ["level"]:
        return _level(value["level"])
    if isinstance(value, str):
        return _read_text(value)
    raise ValueError(_EXPECTED.format(value))


def _read_text(value: str) -> Setpoint:
    if share := re.match(_SHARE, value):
        return Share(float(share[1]), share[2])
    try:
        quantity = parse_quantity(value)
    except QuantityError as error:
        raise ValueError(str(error)) from None
    if quantity.dimension == ANGLE:
        return Target(quantity.value)
    if quantity.dimension == SPEED:
        return Speed(quantity.value)
    if quantity.dimension == TORQUE:
        return HeldTorque(quantity.value)
    if quantity.dimension == DIMENSIONLESS and value.rstrip().endswith("%"):
        if abs(quantity.value) > 1:
            raise ValueError(f"a duty cycle lies between -100 % and 100 %, got '{value}'")
        return Duty(quantity.value)
    raise ValueError(_EXPECTED.format(value))


def _level(value: Any) -> Level:
    if isinstance(target := _read(value), Target):
        return Level(target.angle_rad)
    raise ValueError(f"expected an angle such as '90 deg' as `level`, got '{value}'")


def _write(value: Setpoint) -> str | dict[str, str]:
    match value:
        case Duty(duty):
            return f"{duty * 100:g} %"
        case Target(angle_rad):
            return f"{angle_rad} rad"
        case Share(factor, joint):
            return f"{factor:g} * {joint}"
        case Level(angle_rad):
            return {"level": f"{angle_rad} rad"}
        case Speed(speed):
            return f"{speed} m/s"
        case HeldTorque(torque):
            return f"{torque} Nm"
        case "keep":
            return value


class _WrittenSetpoint:
    """JSON Schema annotation of a setpoint, made when it is asked for."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {
            "anyOf": [
                {"const": KEEP, "description": "The last accepted value stays."},
                {
                    **written_ratio({}),
                    "description": "A duty cycle such as '60 %', of the full voltage.",
                },
                {**written(ANGLE, {}), "description": "An angle such as '-45 deg' to come to."},
                {
                    "type": "string",
                    "pattern": _SHARE,
                    "description": "An angle to come to, as a share of a joint's measured angle.",
                },
                {
                    "type": "object",
                    "additionalProperties": False,
                    "required": ["level"],
                    "properties": {
                        "level": {
                            **written(ANGLE, {}),
                            "description": "The angle to the horizontal.",
                        }
                    },
                    "description": (
                        "An angle against the horizontal, such as {level: 90 deg}, to which the"
                        " part ahead of or behind a roll joint turns: the one that does not hold."
                    ),
                },
                {
                    **written(SPEED, {}),
                    "description": "A speed such as '90 mm/s' at which a wheel rolls.",
                },
                {
                    **written(TORQUE, {}),
                    "description": "A torque such as '350 mNm' that a joint or a wheel bears.",
                },
            ],
            "description": (
                "A duty cycle such as '60 %', an angle such as '-45 deg', a share of the angle of"
                " a joint such as '-0.5 * elbow', an angle against the horizontal such as"
                " {level: 0 deg}, a speed such as '90 mm/s', a torque such as '350 mNm', or keep."
            ),
            "examples": ["60 %", "-45 deg", "-0.5 * elbow", "90 mm/s", "350 mNm", KEEP],
        }


SlotSetpoint = Annotated[Any, BeforeValidator(_read), PlainSerializer(_write), _WrittenSetpoint()]

Stage: TypeAlias = dict[Name, SlotSetpoint]


def _one_stage_is_a_list(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


Stages = Annotated[
    tuple[Stage, ...],
    BeforeValidator(_one_stage_is_a_list),
    Field(min_length=1),
    AlsoWritten(lambda usual: [usual["items"]]),
]


class PostureCase(Frozen):
    """One case of a posture, for a condition on the states: setpoints or a refusal.

    Exactly one of ``set`` and ``refuse`` is given.

    Attributes:
        when: Condition on the states that the command leads to.
        set_: Setpoints of the slots until all joints have reached their angles.
        within: How far a joint may be from its angle; by default the threshold of its loop.
        done: A further criterion of the completed posture.
        refuse: Why the command is impossible where the condition holds.
    """

    when: Condition
    set_: Annotated[Stage | None, Field(alias="set")] = None
    within: Annotated[Angle, Field(gt=0)] | None = None
    done: Criterion | None = None
    refuse: Annotated[str, Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _one_of_two(self) -> PostureCase:
        if (self.set_ is None) == (self.refuse is None):
            raise ValueError("expected exactly one of `set` and `refuse`")
        if self.refuse is not None and (self.done is not None or self.within is not None):
            raise ValueError("`within` and `done` go with `set`: what is refused is never done")
        return self


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
    lower_within: PositiveDuration = 10.0

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
