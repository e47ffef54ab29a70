"""What ends a wait of a mission: a condition, a time, the operator's answer, or the time limit."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Tag

from pirate_sm.model.base import Condition, Frozen, Name, by_key
from pirate_sm.model.quantities import DurationOrParameter


class ConditionTrigger(Frozen):
    """Fires when the condition has been true for ``held``.

    Attributes:
        when: The condition.
        held: How long it must have been true without a break.
        go: The phase or end that it leads to; in a step also nothing, for the next step.
        name: What views, recordings and ``--fire`` call it; else like what it leads to.
    """

    when: Condition
    held: DurationOrParameter = 0.0
    go: Name | None = None
    name: Name | None = None


class TimeTrigger(Frozen):
    """Fires when this much time has passed since the wait was armed.

    Attributes:
        after: How long after the wait began.
        go: The phase or end that it leads to; in a step also nothing, for the next step.
        name: What views, recordings and ``--fire`` call it; else like what it leads to.
    """

    after: DurationOrParameter
    go: Name | None = None
    name: Name | None = None


class OperatorTrigger(Frozen):
    """Fires when the operator gives this answer.

    Attributes:
        operator: The answer, which the operator sees.
        go: The phase or end that it leads to; in a step also nothing, for the next step.
        name: What views, recordings and ``--fire`` call it; else like what it leads to.
    """

    operator: Name
    go: Name | None = None
    name: Name | None = None


Trigger: TypeAlias = Annotated[
    Annotated[ConditionTrigger, Tag("when")]
    | Annotated[TimeTrigger, Tag("after")]
    | Annotated[OperatorTrigger, Tag("operator")],
    by_key(
        ("when", "after", "operator"),
        custom_error_type="trigger",
        custom_error_message="expected a trigger: a mapping with one of when, after, operator",
    ),
]


class Within(Frozen):
    """The longest that a wait may take, and where it leads then.

    Attributes:
        time: How long.
        go: The phase or end that it leads to then; in a step also nothing: the step has failed.
    """

    time: DurationOrParameter
    go: Name | None = None
