"""Campaigns: missions that run many times, in which pipes, with which defects and variations.

A scene of the gallery holds command lines of this program, and what should come of each.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import (
    BeforeValidator,
    Field,
    StringConstraints,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    model_validator,
)

from pirate_sm.core.fields import (
    AlsoWritten,
    AnyQuantity,
    Duration,
    FaultCode,
    Flag,
    Format,
    Frozen,
    Length,
    Name,
    Ratio,
    kind_fault,
    quantity_fault,
    range_fault,
)
from pirate_sm.core.models import DefectText, LineFaults
from pirate_sm.core.options import JITTER, OPTIONS, RunOption
from pirate_sm.core.units import (
    DIMENSIONLESS,
    LENGTH,
    TIME,
    Dimension,
    QuantityError,
    read_quantity,
)
from pirate_sm.lab.campaign.margins_model import Margins
from pirate_sm.lab.campaign.sensitivity_model import VariedRobot

_QUANTITIES: Mapping[Dimension, Any] = {LENGTH: Length, TIME: Duration, DIMENSIONLESS: Ratio}


def _with_options(
    name: str, about: str, options: Mapping[str, RunOption], *, left_open: bool = False
) -> Any:
    """Return a part of a file with options of runs, by their keys there.

    Args:
        name: Name of the class.
        about: What the part is.
        options: The options.
        left_open: Whether one that is left out is None instead of its default.
    """
    lines = [about, "", "Attributes:", *(f"    {key}: {o.help}" for key, o in options.items())]
    kinds: dict[str, Any] = {key: (_written(o), o.default) for key, o in options.items()}
    if left_open:
        kinds = {key: (kind | None, None) for key, (kind, _) in kinds.items()}
    about = "\n".join(lines)
    return create_model(name, __base__=Frozen, __module__=__name__, __doc__=about, **kinds)


def _written(option: RunOption) -> Any:
    kind = Flag if option.type is bool else option.type
    kind = kind if option.unit is None else _QUANTITIES[option.unit]
    return Annotated[kind, Field(ge=option.least, lt=option.below)]


if TYPE_CHECKING:
    StartJitter = Frozen
    PlainChoices = Frozen
else:
    StartJitter = _with_options(
        "StartJitter",
        "How far each run may differ from the files; drawn uniformly within plus and minus.",
        {each.key: each for each in JITTER},
    )
    PlainChoices = _with_options(
        "PlainChoices",
        "What a campaign can say about runs with one value each.",
        {o.word: o for o in OPTIONS.values() if o.in_campaigns == "one" and not o.key},
        left_open=True,
    )


MOST_SEEDS = 10**9
MOST_VALUES = 1000
_SEEDS = re.compile(r"(\d{1,12})\.\.(\d{1,12})")
_SHARE = re.compile(r"(?:>= *)?(\d[\d.]* *%?)")
SimulatedBackend: TypeAlias = Literal["sim", "physics", "bay"]


def _read_seeds(value: Any) -> Sequence[int]:
    """Return the seeds of `0..999`, of a number of seeds, or of a list of seeds."""
    expected = "seeds such as 0..999, a number of seeds or a list of them"
    if isinstance(value, range):
        return value
    if isinstance(value, list | tuple):
        if not value or not all(type(each) is int and each >= 0 for each in value):
            raise kind_fault(f"expected {expected}; a list has one whole number at least")
        if len(set(value)) < len(value):
            raise range_fault("a seed is listed twice: leave one of the two out")
        return tuple(value)
    first, last = 0, -1
    match = _SEEDS.fullmatch(value) if isinstance(value, str) else None
    if match is not None:
        first, last = int(match[1]), int(match[2])
    elif type(value) is int:
        last = value - 1
    else:
        raise kind_fault(f"expected {expected}, got '{value}'")
    if last < first:
        raise range_fault(f"there are no seeds in '{value}'")
    if last - first >= MOST_SEEDS:
        raise range_fault(f"there are more than {MOST_SEEDS:,} seeds in '{value}'")
    return range(first, last + 1)


def _read_share(value: Any, info: ValidationInfo) -> float:
    """Return the share of `>= 99 %` or `99 %`."""
    match = _SHARE.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        if isinstance(value, float) and not info.context:
            return value
        raise kind_fault(f"expected a least share such as '>= 99 %', got '{value}'")
    try:
        share = read_quantity(match[1], DIMENSIONLESS)
    except QuantityError as error:
        raise quantity_fault(error.message, suggestion=error.suggestion) from None
    if share > 1.0:
        raise range_fault(f"expected a share of at most 100 %, got '{value}'")
    return share


def _one_is_a_list(value: Any) -> Any:
    return [value] if isinstance(value, str | int | float | dict) else value


_ONE_IS_A_LIST = BeforeValidator(_one_is_a_list)
_ONE_OR_MANY = AlsoWritten(lambda usual: [usual["items"]])
Seeds: TypeAlias = Annotated[
    Any,
    BeforeValidator(_read_seeds),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": rf"^{_SEEDS.pattern}$"},
                {"type": "integer", "minimum": 1},
                {"type": "array", "items": {"type": "integer", "minimum": 0}, "minItems": 1},
            ],
            "description": "Seeds such as 0..999, a number of seeds, or a list of them.",
            "examples": ["0..999", 100, [17, 230]],
        }
    ),
]

LeastShare: TypeAlias = Annotated[
    float,
    BeforeValidator(_read_share),
    WithJsonSchema(
        {
            "type": "string",
            "pattern": f"^{_SHARE.pattern}$",
            "description": "The least share of the runs, such as '>= 99 %'.",
            "examples": [">= 99 %"],
        }
    ),
]

Texts: TypeAlias = Annotated[tuple[str, ...], _ONE_IS_A_LIST, Field(min_length=1), _ONE_OR_MANY]
Backends: TypeAlias = Annotated[
    tuple[SimulatedBackend, ...], _ONE_IS_A_LIST, Field(min_length=1), _ONE_OR_MANY
]

DefectSet: TypeAlias = Annotated[tuple[DefectText, ...], _ONE_IS_A_LIST, _ONE_OR_MANY]
"""Defects that are switched on together."""

DefectSets: TypeAlias = Annotated[
    tuple[DefectSet, ...], _ONE_IS_A_LIST, Field(min_length=1), _ONE_OR_MANY
]

Value: TypeAlias = str | bool | int | float


class ValueRange(Frozen):
    """Values at equal distances.

    Attributes:
        first: The first value.
        last: No value is beyond this one.
        by: Distance of two values.
    """

    first: Annotated[AnyQuantity, Field(alias="from")]
    last: Annotated[AnyQuantity, Field(alias="to")]
    by: AnyQuantity

    @model_validator(mode="after")
    def _has_values(self) -> ValueRange:
        if len({self.first.dimension, self.last.dimension, self.by.dimension}) > 1:
            raise ValueError("`from`, `to` and `by` need units of one kind")
        if self.by.value <= 0.0:
            raise ValueError("`by` must be more than zero")
        if self.last.value < self.first.value:
            raise ValueError("the range is empty: `to` is less than `from`")
        if (self.last.value - self.first.value) / self.by.value >= MOST_VALUES:
            raise ValueError(f"the range has more than {MOST_VALUES:,} values: make `by` larger")
        return self

    @property
    def count(self) -> int:
        """Return how many values there are."""
        return int((self.last.value - self.first.value) / self.by.value + 1e-9) + 1


Values: TypeAlias = ValueRange | Annotated[tuple[Value, ...], Field(min_length=1)] | Value


class StoppingRule(Frozen):
    """When a cell has had enough runs; without it all seeds run.

    Attributes:
        half_width: A cell ends with the first seed at which half the width of the interval of its
            success is at most this.
        violated: Whether the campaign ends with the first cell that can no longer be as expected,
            whatever its remaining seeds do.
    """

    half_width: Annotated[Ratio, Field(gt=0, lt=0.5)] | None = None
    violated: Flag = False


class Expectation(Frozen):
    """Least shares of the runs of each cell.

    Attributes:
        success: Of runs that succeed, by the simulator's truth too.
        holding: Of runs that succeed, or fail with the robot held in the pipe, in truth.
        truthful: Of runs that do not say falsely that they have succeeded.
        safe: Of runs that end by themselves, with the wheels stopped, with a part held once one
            was, and in the pipe.
    """

    success: LeastShare | None = None
    holding: LeastShare | None = None
    truthful: LeastShare = 1.0
    safe: LeastShare | None = None


class TrueEnd(Frozen):
    """What must be true of the robot when a mission has succeeded.

    Attributes:
        beyond: Every wheel is farther along the pipe than this.
        before: No wheel is farther along the pipe than this.
        at_word: The wheel that the detector's last word is about is at most 15 mm short of where
            the word says.
        states: Combinations of the robot's states that have appeared in this order, others between
            them.
    """

    beyond: Length | None = None
    before: Length | None = None
    at_word: Flag = False
    states: tuple[tuple[str, ...], ...] = ()


class RunChoices(PlainChoices):
    """What a campaign and each of its missions can say about runs.

    Attributes:
        robot: Name or path, instead of the missions' own.
        pipe: Names or paths, instead of the missions' own; one, or a list.
        defects: Each item is `none`, a defect with its numbers, or a list of defects at once;
            `each` stands for every defect of the robot, with numbers too, and twice in a list for
            every pair.
        set: Values of parameters by name: one, a list, or a range with `from`, `to` and `by`.
        backend: `sim`, `physics`, or `bay`, the serial link to an emulated robot; one, or a list.
        detector: Names of detectors, instead of the backend's usual one; one, or a list.
        line: Faults of the serial line, for the backend `bay`.
        jitter: How far each run may differ from the files.
        seeds: Which seeds run.
        expect: Least shares, below which the campaign fails.
        end: What must be true when a mission has succeeded.
    """

    robot: str | None = None
    pipe: Texts | None = None
    defects: DefectSets | None = None
    set: dict[Name, Values] | None = None
    backend: Backends | None = None
    detector: Texts | None = None
    line: LineFaults | None = None
    jitter: StartJitter | None = None
    seeds: Seeds | None = None
    expect: Expectation | None = None
    end: TrueEnd | None = None


class CampaignMission(RunChoices):
    """A mission of a campaign; what it says replaces what the campaign says.

    Attributes:
        mission: Name or path.
        name: What its cells are called, instead of the mission's name.
    """

    mission: str
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None


def _bare_mission(value: Any) -> Any:
    return {"mission": value} if isinstance(value, str) else value


class Campaign(RunChoices):
    """A campaign: every mission in every pipe with all defects and parameters, many times.

    Attributes:
        format: Version of this format.
        campaign: Name of the campaign.
        description: One-line description.
        missions: The missions; a name, a path, or a mapping with choices of its own.
        confidence: Of all intervals.
        stop: When a cell has had enough runs.
        sensitivity: Which numbers of the robot are varied, to see which of them decide.
        margins: How far its cells hold when factors are changed.
    """

    format: Format
    campaign: Name
    description: str = ""
    missions: Annotated[
        tuple[
            Annotated[
                CampaignMission,
                BeforeValidator(_bare_mission),
                AlsoWritten(lambda usual: [{"type": "string"}]),
            ],
            ...,
        ],
        Field(min_length=1),
    ]
    confidence: Annotated[Ratio, Field(gt=0, lt=1)] = 0.95
    stop: StoppingRule = StoppingRule()
    sensitivity: VariedRobot | None = None
    margins: Margins | None = None


Line: TypeAlias = Annotated[str, StringConstraints(min_length=1, max_length=400)]
CommandLine: TypeAlias = Annotated[str, StringConstraints(min_length=1, max_length=4000)]
"""A run with a number for each factor of a margin has some 600 characters."""

Extra: TypeAlias = Literal["physics", "serial", "vision"]
"""An extra that a scene needs; without it the scene is left out."""


class Expected(Frozen):
    """What should come of a step.

    The last setpoints of every recorded run must let the wheels stand; this needs no key.

    Attributes:
        exit: The exit code.
        ended: How the recorded run ends.
        says: Text in the reason of its end, or in the output of a command that records nothing.
        faults: Faults that the run reports, at least these.
        held: Whether the robot is held at the end of a recorded run, by the simulator's truth.
    """

    exit: Annotated[int, Field(ge=0, le=255)] = 0
    ended: Literal["succeeded", "failed", "interrupted", "fault"] | None = None
    says: str = ""
    faults: tuple[FaultCode, ...] = ()
    held: Flag = True


class SceneStep(Frozen):
    """A step of a scene.

    Attributes:
        about: What happens now, in a sentence.
        command: A command line of this program. ``{out}`` is the scene's folder for output,
            ``{here}`` the folder of the scene's file. A run gets the scene's speed; one that is to
            be judged has ``--record``.
        power_cut_in: A phase of the recorded mission in which the run is killed, as by a power cut.
            Nothing else is expected of the step then.
        expect: What should come of it.
    """

    about: Line | None = None
    command: CommandLine
    power_cut_in: Name | None = None
    expect: Expected = Expected()


class Scene(Frozen):
    """A scene of the gallery, played by ``pirate demo``.

    Attributes:
        format: Version of this format.
        scene: Name of the scene, as its file.
        title: What happens, in a line.
        look_at: What to look at, in some sentences.
        needs: Extras that must be installed.
        speed: Mission seconds per second while somebody watches.
        steps: What is done, in order.
    """

    format: Format
    scene: Name
    title: Line
    look_at: Annotated[str, StringConstraints(min_length=1, max_length=1_000)]
    needs: tuple[Extra, ...] = ()
    speed: Annotated[float, Field(gt=0, le=100)] = 2.0
    steps: Annotated[tuple[SceneStep, ...], Field(min_length=1)]
