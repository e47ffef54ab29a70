"""Safety rules of a robot: `always`, `never`, and `expect` within some steps."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pirate_sm.core._model.base import Condition, Frozen, Name
from pirate_sm.core._model.quantities import Count


class SafetyRule(Frozen):
    """A safety rule: a condition that must always or never hold, whatever a mission commands.

    Exactly one of ``always``, ``never`` and ``expect`` is given. Conditions see the state of each
    region, ``command`` (just accepted), ``clamps`` (parts that the states hold),
    ``confirmed_clamps`` and ``driven_wheels``.

    Attributes:
        rule: Name of the rule.
        always: A condition that must hold.
        never: A condition that must not hold.
        after: The rule applies once this has been true.
        expect: A condition that must become true in time after ``after``.
        within_steps: With ``expect``: how many commands may be accepted until it holds.
        why: What happens if the rule is broken.
        waived_by: The key of a mission that waives the rule, with a reason.
    """

    rule: Name
    always: Condition | None = None
    never: Condition | None = None
    after: Condition | None = None
    expect: Condition | None = None
    within_steps: Annotated[Count, Field(ge=1, le=1000)] | None = None
    why: str = ""
    waived_by: Literal["allow_unclamp"] | None = None

    @model_validator(mode="after")
    def _one_of_three(self) -> SafetyRule:
        if sum(each is not None for each in (self.always, self.never, self.expect)) != 1:
            raise ValueError("expected exactly one of `always`, `never` and `expect`")
        if (self.expect is None) != (self.within_steps is None):
            raise ValueError("`expect` and `within_steps` go together")
        if self.expect is not None and self.after is None:
            raise ValueError("`expect` needs `after`: what it is expected to follow")
        return self
