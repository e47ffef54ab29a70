"""Triggers of waits: a condition, a time, the operator's answer."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Tag

from pirate_sm.core._model.base import Condition, Frozen, Name, by_key
from pirate_sm.core._model.quantities import DurationOrParameter


class ConditionTrigger(Frozen):
    """Fires when the condition has been true for ``held``.

    Attributes:
        when: The condition.
        held: How long it must have been true without interruption.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
    """

    when: Condition
    held: DurationOrParameter = 0.0
    go: Name | None = None
    name: Name | None = None


class TimeTrigger(Frozen):
    """Fires when this much time has passed since the wait was armed.

    Attributes:
        after: Time since the wait began.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
    """

    after: DurationOrParameter
    go: Name | None = None
    name: Name | None = None


class OperatorTrigger(Frozen):
    """Fires when the operator gives this answer.

    Attributes:
        operator: The answer, as shown to the operator.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
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
    """The time limit of a wait, and the target after it.

    Attributes:
        time: The time limit.
        go: The target phase or end; optional in a step, which then fails.
    """

    time: DurationOrParameter
    go: Name | None = None
