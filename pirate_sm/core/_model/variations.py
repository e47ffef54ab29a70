"""How a run may differ from what the files of the robot and the pipe say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, create_model

from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.quantities import Duration, Flag, Length, Ratio
from pirate_sm.core._model.run_options import JITTER, OPTIONS, RunOption
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, TIME, Dimension

_QUANTITIES: Mapping[Dimension, Any] = {LENGTH: Length, TIME: Duration, DIMENSIONLESS: Ratio}


def with_options(
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
    StartJitter = with_options(
        "StartJitter",
        "How far each run may differ from the files; drawn uniformly within plus and minus.",
        {each.key: each for each in JITTER},
    )
    PlainChoices = with_options(
        "PlainChoices",
        "What a campaign can say about runs with one value each.",
        {o.word: o for o in OPTIONS.values() if o.in_campaigns == "one" and not o.key},
        left_open=True,
    )


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
