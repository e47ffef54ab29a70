"""A mission as written in its file; :mod:`pirate_sm.core._loading.mission` resolves the names.

The language and its twelve rules are documented in ``docs/missions.md``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, TypeAlias, TypeVar, get_args

from pydantic import AfterValidator, BeforeValidator, Field, Strict, Tag, model_validator
from pydantic_core import PydanticCustomError

from pirate_sm.core._model.base import (
    DEFINED,
    OR_ONE,
    AlsoWritten,
    Condition,
    Defined,
    FaultCode,
    Format,
    Frozen,
    Name,
    by_key,
)
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.quantities import CountOrParameter, DurationOrParameter, key_fault
from pirate_sm.core._model.triggers import (
    ConditionTrigger,
    OperatorTrigger,
    TimeTrigger,
    Trigger,
    Within,
)
from pirate_sm.core.units import (
    ANGLE,
    ANGULAR_SPEED,
    CURRENT,
    DIMENSIONLESS,
    FORCE,
    LENGTH,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
    QuantityError,
    parse_quantity,
)

ParameterType: TypeAlias = Literal[
    "duration", "length", "angle", "speed", "angular_speed", "torque", "force", "current",
    "ratio", "count", "number",
]  # fmt: skip
DIMENSIONS: Mapping[str, Dimension] = {
    "duration": TIME, "length": LENGTH, "angle": ANGLE, "speed": SPEED,
    "angular_speed": ANGULAR_SPEED, "torque": TORQUE, "force": FORCE, "current": CURRENT,
    "ratio": DIMENSIONLESS, "count": DIMENSIONLESS, "number": DIMENSIONLESS,
}  # fmt: skip
# Strict, because `true` would count as 1.
ParameterValue: TypeAlias = (
    Annotated[str, Strict()] | Annotated[int, Strict()] | Annotated[float, Strict()]
)


class ParameterDefinition(Frozen):
    """A parameter of a mission; without a default it must be given.

    Attributes:
        type: The kind of value, which determines the valid units.
        default: The value if none is given; without a default it must be given.
        min: The smallest valid value.
        max: The largest valid value.
        description: One-line description.
    """

    type: ParameterType
    default: ParameterValue | None = None
    min: ParameterValue | None = None
    max: ParameterValue | None = None
    description: str = ""


def type_of(value: object) -> ParameterType | None:
    """Return the type of parameter that has such a value; None without a unit."""
    try:
        dimension = parse_quantity(str(value)).dimension
    except QuantityError:
        return None
    known: tuple[ParameterType, ...] = get_args(ParameterType)
    sure = (each for each in known if DIMENSIONS[each] == dimension != DIMENSIONLESS)
    return next(sure, None)


_L = TypeVar("_L", ConditionTrigger, TimeTrigger, OperatorTrigger, Within)
_W = TypeVar("_W", "WaitStep", "Phase")

CONTINUE = "continue"
FAIL = "fail"

CONTROL_WITHIN_S = 10.0
"""How long the joints may take to bear the torques of a control [decided]."""


class _AnyStep(Frozen):
    """The keys common to all steps: a condition, and the target of a failure.

    Attributes:
        condition: The step is skipped unless this is true.
        on_failure: Target of a failure: a phase or end, or ``continue`` for the next step.
    """

    condition: Annotated[Condition | None, Field(alias="if")] = None
    on_failure: Name | None = None


class CommandStep(_AnyStep):
    """A command; the mission waits until it is done.

    Attributes:
        command: The command's name, or an alias that the robot declares.
        timeout: Overrides the profile's timeout; counts from acceptance.
        retry: How often the command is repeated after a failure.
        unneeded: Whether an unneeded command counts as done (``skip``) or as a failure (``fail``).
    """

    command: Annotated[str, Defined("CommandName")]
    timeout: DurationOrParameter | None = None
    retry: CountOrParameter = 0
    unneeded: Literal["skip", "fail"] = "fail"


class CallStep(_AnyStep):
    """Another mission, inlined with its arguments.

    Attributes:
        call: The other mission: its name, or a path from this file's folder.
        arguments: Values of its parameters, by name; ``$name`` passes a parameter of this mission.
    """

    call: str
    arguments: Annotated[dict[Name, ParameterValue], Field(alias="with")] = {}


class RepeatBody(Frozen):
    """Steps to be repeated.

    Attributes:
        times: Number of repetitions.
        do: The steps, one after the other.
    """

    times: CountOrParameter
    do: Annotated[tuple[Step, ...], Field(min_length=1)]


class RepeatStep(_AnyStep):
    """A repetition of steps.

    Attributes:
        repeat: The steps, and the number of repetitions.
    """

    repeat: RepeatBody


class Choice(Frozen):
    """Steps to be executed if the condition is true.

    Attributes:
        condition: The condition for executing these steps.
        do: The steps, one after the other.
    """

    condition: Annotated[Condition, Field(alias="if")]
    do: tuple[Step, ...]


class ChooseStep(_AnyStep):
    """Executes the first choice whose condition is true, otherwise ``else``.

    Attributes:
        choose: The choices, tested in order.
        otherwise: The steps if no condition is true.
    """

    choose: Annotated[tuple[Choice, ...], Field(min_length=1)]
    otherwise: Annotated[tuple[Step, ...], Field(alias="else")] = ()


class AskStep(_AnyStep):
    """A question to the operator; each choice continues, fails, or goes to a phase or end.

    Attributes:
        ask: The question.
        choices: The target of each answer: ``continue``, ``fail``, a phase or an end.
        timeout: How long to wait for an answer before the step fails.
    """

    ask: str
    choices: Annotated[dict[str, str], Field(min_length=1)] = {"yes": CONTINUE, "no": FAIL}
    timeout: DurationOrParameter | None = None


class LogStep(_AnyStep):
    """A line for the operator.

    Attributes:
        log: The text; ``{name}`` is replaced by a parameter's value.
        level: The log level.
    """

    log: str
    level: Literal["info", "warning"] = "info"


class ControlStep(_AnyStep):
    """Another control from now on; done once every joint bears the torque that it names.

    Attributes:
        control: The control's name, or ``none`` for the robot's usual actuation.
        timeout: How long the joints may take.
    """

    control: Annotated[str, Defined("ControlName")]
    timeout: DurationOrParameter = CONTROL_WITHIN_S


class WaitStep(_AnyStep):
    """A wait among the steps; the next step follows unless the trigger has a target.

    Attributes:
        wait: Triggers; the first to fire decides. Without ``go`` it leads to the next step.
        within: Time limit of the wait. Without ``go`` the step fails after it.
        counts_on: Whether changes of signals count from where the last wait counted them.
    """

    wait: Annotated[tuple[Trigger, ...], Field(min_length=1)]
    within: Within | None = None
    counts_on: bool = False

    @model_validator(mode="after")
    def _comes_to_an_end(self) -> WaitStep:
        if self.within is None and not any(isinstance(each, TimeTrigger) for each in self.wait):
            raise ValueError("a `wait` needs `within: {time: …}`, here next to it")
        return _counting(self)


_STEP_KINDS = ("command", "call", "repeat", "choose", "ask", "log", "wait", "control")


def _bare_command(value: Any) -> Any:
    return {"command": value} if isinstance(value, str) else value


Step: TypeAlias = Annotated[
    Annotated[
        Annotated[CommandStep, Tag("command")]
        | Annotated[CallStep, Tag("call")]
        | Annotated[RepeatStep, Tag("repeat")]
        | Annotated[ChooseStep, Tag("choose")]
        | Annotated[AskStep, Tag("ask")]
        | Annotated[LogStep, Tag("log")]
        | Annotated[WaitStep, Tag("wait")]
        | Annotated[ControlStep, Tag("control")],
        by_key(
            _STEP_KINDS,
            custom_error_type="step",
            custom_error_message="expected a step: a command's name, or a mapping with one of "
            + ", ".join(_STEP_KINDS),
        ),
    ],
    BeforeValidator(_bare_command),
    AlsoWritten(lambda _: [{DEFINED: "CommandName"}]),
]


def every_step(
    steps: Sequence[Step], at: tuple[str | int, ...] = ()
) -> Iterator[tuple[Step, tuple[str | int, ...]]]:
    """Yield the steps and those inside them, in the order of the file, each with where it stands.

    Args:
        steps: The steps.
        at: Where they stand: keys and list indexes from the root of the file.
    """
    for number, step in enumerate(steps):
        path = (*at, number)
        yield step, path
        match step:
            case RepeatStep():
                yield from every_step(step.repeat.do, (*path, "repeat", "do"))
            case ChooseStep():
                for arm, choice in enumerate(step.choose):
                    yield from every_step(choice.do, (*path, "choose", arm, "do"))
                yield from every_step(step.otherwise, (*path, "else"))
            case CommandStep() | CallStep() | AskStep() | WaitStep() | ControlStep() | LogStep():
                pass


class FaultHandler(Frozen):
    """The handling of a fault: only log it, or go to a phase.

    Attributes:
        fault: Code of a fault, ``family.detail``, or a list of codes.
        of: Boards (``board_26``), joints, wheels and parts: the line is only for a fault of these
            and of nothing else. Without it the line is for everybody's.
        then: ``continue``: only log it.
        go: The target phase or end.
    """

    fault: Annotated[tuple[FaultCode, ...], Field(min_length=1), *OR_ONE]
    of: Annotated[
        tuple[Annotated[Name, Defined("FaultOwner")], ...], Field(min_length=1), *OR_ONE
    ] = ()
    then: Literal["continue"] | None = None
    go: Name | None = None

    @property
    def whose(self) -> str:
        """Return ``of`` and the names that it gives, or nothing, to follow the codes."""
        return f" of {', '.join(self.of)}" if self.of else ""

    @model_validator(mode="after")
    def _one_of_two(self) -> FaultHandler:
        if (self.then is None) == (self.go is None):
            raise key_fault("expected either `then: continue` or `go: <phase>`", "then", "go")
        return self


def _leading(part: _L) -> _L:
    """Return the part; raise an error if it has no target."""
    if part.go is None:
        raise PydanticCustomError(
            "missing-key", "this needs `go`: the phase or end that it leads to", {"keys": "go"}
        )
    return part


def _counting(part: _W) -> _W:
    """Return the part with a wait; raise an error if it counts on and nothing in it counts."""
    conditions = [each.when for each in part.wait if isinstance(each, ConditionTrigger)]
    if part.counts_on and not any("change" in when for when in conditions):
        raise ValueError("`counts_on` is for a `wait` with change(…), and nothing counts here")
    return part


class Phase(Frozen):
    """Steps in order, followed by a wait for one of several triggers, or by ``go``.

    Attributes:
        description: One-line description.
        do: The steps, one after the other.
        wait: Triggers; the first to fire decides.
        within: Time limit of the wait, and the target after it.
        counts_on: Whether changes of signals count from where the last wait counted them.
        go: The next phase or end, in a phase without ``wait``.
        on_failure: The target phase or end of a failure of one of its steps.
        resume: Where the mission goes on if its run is cut off in this phase: ``here``, at another
            phase, or ``never``.
    """

    description: str = ""
    do: tuple[Step, ...] = ()
    wait: tuple[Annotated[Trigger, AfterValidator(_leading)], ...] = ()
    within: Annotated[Within, AfterValidator(_leading)] | None = None
    counts_on: bool = False
    go: Name | None = None
    on_failure: Name | None = None
    resume: Name = "here"

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
        return _counting(self)


class End(Frozen):
    """An end of a mission: success or failure, with a message for the operator.

    Attributes:
        succeed: The mission has succeeded; the message for the operator.
        fail: The mission has failed; the message for the operator, which may use ``{cause}`` and
            ``{driven}``.
    """

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
        format: Version of this language.
        mission: Name of the mission.
        description: One-line description.
        robot: Name of a shipped robot, or the path of a robot's folder.
        pipe: Name of a pipe, a path, or an inline pipe.
        route: The route through the pipe; by default its first.
        polarity: Which sides the wheels touch; by default the caller's, or ``normal``.
        parameters: Parameters by name; constant during a run.
        starts_in: The state that each region must be in at the start and at a call.
        control: The control that the robot's states are actuated by; else the usual one.
        time_limit: Longest time for the whole run.
        allow_unclamp: Why this mission may let go of the pipe; a reason that people read.
        on_failure: The phase or end that a failure leads to; without one, the safe stop.
        on_fault: What to do about faults; one that no line names ends the mission in the safe
            state.
        start: The first phase.
        phases: The phases by name.
        ends: The ends by name.
    """

    format: Format
    mission: Name
    description: str = ""
    robot: str
    pipe: Annotated[str | Pipe | None, Field(union_mode="left_to_right")] = None
    route: Name | None = None
    polarity: Literal["normal", "mirrored"] | None = None
    parameters: dict[Name, ParameterDefinition] = {}
    starts_in: dict[Name, Name] | None = None
    control: Annotated[str, Defined("ControlName")] | None = None
    time_limit: DurationOrParameter | None = None
    allow_unclamp: Annotated[str, Field(min_length=1)] | None = None
    on_failure: Name | None = None
    on_fault: tuple[FaultHandler, ...] = ()
    start: Name
    phases: Annotated[dict[Name, Phase], Field(min_length=1)]
    ends: Annotated[dict[Name, End], Field(min_length=1)]
