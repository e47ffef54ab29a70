"""Conditions on changes as they are when their wait begins."""

from __future__ import annotations

import pytest

from pirate_sm.checking.mission.wait_triggers import at_beginning
from pirate_sm.core.expressions import NumberType, Vocabulary, compile_condition
from pirate_sm.core.units import DIMENSIONLESS

NAMES = Vocabulary({name: NumberType(DIMENSIONLESS) for name in ("turned", "rolled", "still")})
CHANGES = frozenset({"turned", "rolled"})


@pytest.mark.parametrize(
    ("condition", "then"),
    [
        ("turned > 1", "0 > 1"),
        ("still > 1", "still > 1"),
        ("-turned < abs(rolled)", "-0 < abs(0)"),
        ("max(turned, still) - rolled > 1", "max(0, still) - 0 > 1"),
        ("turned > 1 and still > 2 and rolled > 3", "0 > 1 and still > 2 and 0 > 3"),
        ("turned > 1 or still > 2 or rolled > 3", "0 > 1 or still > 2 or 0 > 3"),
        ("not (turned > 1 or rolled > 2)", "not (0 > 1 or 0 > 2)"),
        ("known(turned)", "known(turned)"),
    ],
)
def test_a_change_is_nothing_when_its_wait_begins(condition: str, then: str) -> None:
    found = at_beginning(compile_condition(condition, NAMES).tree, CHANGES)

    assert found == compile_condition(then, NAMES).tree
