"""A mission as its file says it; names are resolved in :mod:`pirate_sm.loading.mission`.

The language and its twelve rules are documented in ``docs/missions.md``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Discriminator, Field, Strict, Tag, model_validator

from pirate_sm.model.base import FaultCode, Frozen, Name
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.quantities import CountOrParameter, DurationOrParameter

CONTINUE = "continue"
FAIL = "fail"

ParameterType: TypeAlias = Literal[
    "duration", "length", "angle", "speed", "angular_speed", "torque", "force", "current",
    "ratio", "count", "number",
]  # fmt: skip
# Strict: else `true` would be the count 1.
ParameterValue: TypeAlias = (
    Annotated[str, Strict()] | Annotated[int, Strict()] | Annotated[float, Strict()]
)


class ParameterDefinition(Frozen):
    """A constant of a run; without a default it must be given."""

    type: ParameterType
    default: ParameterValue | None = None
    min: ParameterValue | None = None
    max: ParameterValue | None = None
    description: str = ""


class _AnyStep(Frozen):
    """What every step may say: when it is done at all, and where its failure leads.

    Attributes:
        condition: The step is passed over unless this is true.
        on_failure: A phase or end, or ``continue`` for the next step.
    """

    condition: Annotated[str | None, Field(alias="if")] = None
    on_failure: Name | None = None


class CommandStep(_AnyStep):
    """One command, awaited until it is done.

    Attributes:
        timeout: In place of the profile's; counts from acceptance.
        retry: How often the same command is sent again after a failure.
        unneeded: ``skip`` takes an unneeded command as done; ``fail`` as a failure.
    """

    command: str
    timeout: DurationOrParameter | None = None
    retry: CountOrParameter = 0
    unneeded: Literal["skip", "fail"] = "fail"


class CallStep(_AnyStep):
    """Another mission, inlined with its arguments."""

    call: str
    arguments: Annotated[dict[Name, ParameterValue], Field(alias="with")] = {}


class RepeatBody(Frozen):
    """Steps to be done so many times."""

    times: CountOrParameter
    do: Annotated[tuple[Step, ...], Field(min_length=1)]


class RepeatStep(_AnyStep):
    """The same steps several times."""

    repeat: RepeatBody


class Choice(Frozen):
    """Steps to be done if the condition is true."""

    condition: Annotated[str, Field(alias="if")]
    do: tuple[Step, ...]


class ChooseStep(_AnyStep):
    """The first choice whose condition is true; otherwise ``else``."""

    choose: Annotated[tuple[Choice, ...], Field(min_length=1)]
    otherwise: Annotated[tuple[Step, ...], Field(alias="else")] = ()


class AskStep(_AnyStep):
    """A question to the operator; each choice continues, fails, or goes to a phase or end."""

    ask: str
    choices: Annotated[dict[str, str], Field(min_length=1)] = {"yes": CONTINUE, "no": FAIL}
    timeout: DurationOrParameter | None = None


class LogStep(_AnyStep):
    """A line for the operator."""

    log: str
    level: Literal["info", "warning"] = "info"


_STEP_KINDS = ("command", "call", "repeat", "choose", "ask", "log")


def _bare_command(value: Any) -> Any:
    return {"command": value} if isinstance(value, str) else value


def _kind_of_step(value: Any) -> str | None:
    for kind in _STEP_KINDS:
        if (isinstance(value, dict) and kind in value) or hasattr(value, kind):
            return kind
    return None


Step: TypeAlias = Annotated[
    Annotated[
        Annotated[CommandStep, Tag("command")]
        | Annotated[CallStep, Tag("call")]
        | Annotated[RepeatStep, Tag("repeat")]
        | Annotated[ChooseStep, Tag("choose")]
        | Annotated[AskStep, Tag("ask")]
        | Annotated[LogStep, Tag("log")],
        Discriminator(
            _kind_of_step,
            custom_error_type="step",
            custom_error_message=(
                "expected a step: a command's name, or a mapping with one of command, call, "
                "repeat, choose, ask, log"
            ),
        ),
    ],
    BeforeValidator(_bare_command),
]


class ConditionTrigger(Frozen):
    """Fires when the condition has been true for ``held``."""

    when: str
    held: DurationOrParameter = 0.0
    go: Name
    name: Name | None = None


class TimeTrigger(Frozen):
    """Fires when so much time has passed since the wait was armed."""

    after: DurationOrParameter
    go: Name
    name: Name | None = None


class OperatorTrigger(Frozen):
    """Fires when the operator gives this answer."""

    operator: Name
    go: Name
    name: Name | None = None


_TRIGGER_KINDS = ("when", "after", "operator")


def _kind_of_trigger(value: Any) -> str | None:
    for kind in _TRIGGER_KINDS:
        if (isinstance(value, dict) and kind in value) or hasattr(value, kind):
            return kind
    return None


Trigger: TypeAlias = Annotated[
    Annotated[ConditionTrigger, Tag("when")]
    | Annotated[TimeTrigger, Tag("after")]
    | Annotated[OperatorTrigger, Tag("operator")],
    Discriminator(
        _kind_of_trigger,
        custom_error_type="trigger",
        custom_error_message="expected a trigger: a mapping with one of when, after, operator",
    ),
]


class Within(Frozen):
    """The longest that a wait may take, and where it leads then."""

    time: DurationOrParameter
    go: Name


class FaultHandler(Frozen):
    """What to do about a fault: only log it, or go to a phase."""

    fault: Annotated[
        tuple[FaultCode, ...],
        BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
        Field(min_length=1),
    ]
    then: Literal["continue"] | None = None
    go: Name | None = None

    @model_validator(mode="after")
    def _one_of_two(self) -> FaultHandler:
        if (self.then is None) == (self.go is None):
            raise ValueError("expected either `then: continue` or `go: <phase>`")
        return self


class Phase(Frozen):
    """Steps in order, then a wait for one of several triggers, or straight on to ``go``."""

    description: str = ""
    do: tuple[Step, ...] = ()
    wait: tuple[Trigger, ...] = ()
    within: Within | None = None
    go: Name | None = None
    on_failure: Name | None = None

    @model_validator(mode="after")
    def _waits_or_goes(self) -> Phase:
        timed = any(isinstance(trigger, TimeTrigger) for trigger in self.wait)
        if self.wait and self.go is not None:
            raise ValueError("a phase with `wait` has no `go`: its triggers say where it goes")
        if not self.wait and self.go is None:
            raise ValueError("a phase without `wait` needs `go`: the phase or end that comes next")
        if self.wait and self.within is None and not timed:
            raise ValueError("a phase with `wait` needs `within: {time: …, go: …}`")
        if self.within is not None and not self.wait:
            raise ValueError("`within` limits a `wait`, and this phase has none")
        return self


class End(Frozen):
    """How a mission ends: exactly one of the two, with the sentence that the operator reads."""

    succeed: str | None = None
    fail: str | None = None

    @model_validator(mode="after")
    def _one_of_two(self) -> End:
        if (self.succeed is None) == (self.fail is None):
            raise ValueError("expected either `succeed: <message>` or `fail: <message>`")
        return self


class Mission(Frozen):
    """A whole mission.

    Attributes:
        allow_unclamp: Why this mission may let go of the pipe; a reason that people read.
    """

    format: Literal[1]
    mission: Name
    description: str = ""
    robot: str
    pipe: Annotated[str | Pipe | None, Field(union_mode="left_to_right")] = None
    polarity: Literal["normal", "mirrored"] | None = None
    parameters: dict[Name, ParameterDefinition] = {}
    starts_in: dict[Name, Name] | None = None
    time_limit: DurationOrParameter | None = None
    allow_unclamp: Annotated[str, Field(min_length=1)] | None = None
    on_failure: Name | None = None
    on_fault: tuple[FaultHandler, ...] = ()
    start: Name
    phases: Annotated[dict[Name, Phase], Field(min_length=1)]
    ends: Annotated[dict[Name, End], Field(min_length=1)]


RepeatBody.model_rebuild()
RepeatStep.model_rebuild()
Choice.model_rebuild()
ChooseStep.model_rebuild()
Phase.model_rebuild()
Mission.model_rebuild()
