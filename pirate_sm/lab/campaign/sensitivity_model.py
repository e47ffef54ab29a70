"""Which numbers of a robot a campaign varies, from where to where, to see which of them decide."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from pydantic import (
    BeforeValidator,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    model_validator,
)

from pirate_sm.core.fields import Count, Frozen, Name, kind_fault, range_fault
from pirate_sm.core.models import PARTS_OF_A_TWIN, Twin
from pirate_sm.core.units import parse_quantity, unit_of

MOST_POINTS = 2**20
"""The most points; more runs than a campaign of 10 million could not be waited for [decided]."""


class Factor(NamedTuple):
    """A number that the runs of a cell draw, uniformly unless from the sample of a twin.

    Attributes:
        name: What differs from the files, such as ``start_m``; the number of a defect: its name,
            ``_`` and the key; of a twin's sample: its motor, ``_`` and the key; or of the robot:
            ``motors.bend.stall_torque``.
        unit: The SI unit; empty for a share.
        low: Its least value; likewise ``high``.
    """

    name: str
    unit: str
    low: float
    high: float


def _drawn(model: type[Frozen]) -> Any:
    """Return a part of a file in which each number of a model is a range instead."""
    kinds: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        reader = TypeAdapter(field.rebuild_annotation())
        kinds[name] = Annotated[Any, BeforeValidator(partial(_read_range, reader)), _RANGE], None
    lines = (model.__doc__ or "").replace("instead of the profile's; what is", "each a range; what")
    return create_model(f"Drawn{model.__name__}", __base__=Frozen, __doc__=lines, **kinds)


def _read_range(reader: TypeAdapter[float], value: Any, info: ValidationInfo) -> Any:
    """Return the range of `0.5 Nm..2 Nm`, of which both ends are numbers that a reader takes."""
    if isinstance(value, Factor) and not info.context:
        return value
    low, dots, high = map(str.strip, str(value).partition(".."))
    if not dots:
        raise kind_fault(f"expected a range such as 0.5 Nm..2 Nm, got '{value}'")
    try:
        ends = [reader.validate_python(_plain(each), context=info.context) for each in (low, high)]
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        beyond = {"gt", "ge", "lt", "le"} & fault.get("ctx", {}).keys()
        message = f"'{value}' goes beyond what this can be" if beyond else fault["msg"]
        raise kind_fault(message) from None
    if not ends[0] < ends[1]:
        raise range_fault(f"there is nothing to draw in '{value}'")
    return Factor("", unit_of(parse_quantity(high).dimension), *ends)


def _plain(text: str) -> str | float:
    """Return a plain number as one, as files have it, and anything else as it is."""
    try:
        return float(text)
    except ValueError:
        return text


_RANGE = WithJsonSchema(
    {
        "type": "string",
        "pattern": r"^.+\.\..+$",
        "description": "From where to where the number is drawn, with units.",
        "examples": ["0.5 Nm..2 Nm"],
    }
)

if TYPE_CHECKING:
    DrawnMotorNumbers = Frozen
    DrawnFriction = Frozen
    DrawnNoise = Frozen
    DrawnTyre = Frozen
else:
    DrawnMotorNumbers, DrawnFriction, DrawnNoise, DrawnTyre = (
        _drawn(PARTS_OF_A_TWIN[part]) for part in ("motors", "friction", "noise", "tyre")
    )


def _ranges(numbers: Frozen | None) -> dict[str, Factor]:
    return {} if numbers is None else {key: each for key, each in numbers if each is not None}


class DrawnNumbers(Frozen):
    """What is drawn of the simulated robot: the keys of a twin, with ranges.

    Attributes:
        motors: By kind of motor.
        joints: The same of the motor of one joint.
        friction: Between wheel and wall; one coefficient alone scales the other with it.
        noise: Of the sensors.
        tyre: Of every wheel.
    """

    motors: dict[Name, DrawnMotorNumbers] = {}
    joints: dict[Name, DrawnMotorNumbers] = {}
    friction: DrawnFriction | None = None
    noise: DrawnNoise | None = None
    tyre: DrawnTyre | None = None

    @model_validator(mode="after")
    def _can_be_drawn(self) -> DrawnNumbers:
        if len(self.factors) < 2:
            raise ValueError("name two numbers at least: of one alone nothing can be compared")
        found = _ranges(self.friction)
        static, kinetic = found.get("static"), found.get("kinetic")
        if static and kinetic and static.low < kinetic.high:
            raise ValueError("draw one coefficient of friction, which scales the other with it")
        return self

    @property
    def factors(self) -> tuple[Factor, ...]:
        """What is drawn, each by the keys that lead to it."""
        groups = {"friction": self.friction, "noise": self.noise, "tyre": self.tyre}
        groups |= {f"motors.{name}": each for name, each in self.motors.items()}
        groups |= {f"joints.{name}": each for name, each in self.joints.items()}
        return tuple(
            found._replace(name=f"{group}.{key}")
            for group, numbers in groups.items()
            for key, found in _ranges(numbers).items()
        )

    def least(self, robot: str) -> Twin:
        """Return the twin whose motors have the least of what is drawn of them."""
        low: dict[str, Any] = {
            group: {
                name: {key: each.low for key, each in _ranges(numbers).items()}
                for name, numbers in found.items()
            }
            for group, found in (("motors", self.motors), ("joints", self.joints))
        }
        return Twin(format=1, robot=robot, **low)


class VariedRobot(Frozen):
    """Which numbers of the robot decide the outcome of its runs.

    Attributes:
        method: ``sobol``: which share of the variance is due to each number, alone and with others.
            ``morris``: how much each number changes, for few runs.
        points: How many points of Sobol's sequence, a power of two, each with two runs more than
            there are numbers; or Morris's paths, each with one run more.
        numbers: What is drawn, from where to where.
    """

    method: Literal["sobol", "morris"]
    points: Annotated[Count, Field(ge=2, le=MOST_POINTS)]
    numbers: DrawnNumbers

    @model_validator(mode="after")
    def _is_a_power_of_two(self) -> VariedRobot:
        if self.method == "sobol" and self.points & (self.points - 1):
            raise ValueError("`points` of Sobol's sequence are a power of two, such as 64 or 256")
        return self
