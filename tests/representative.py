"""Which of many like cases the default tests take; the thorough ones take them all.

A test that goes through every shipped mission shows most of what it can show with a few of them.
The others run with ``-m thorough`` (`make test-thorough`), as CI does.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any, TypeVar

import pytest

MISSIONS = {
    "mitre_bend",  # calls, faults, a bend in the plane
    "mitre_bend_backward",
    "take_branch",  # a round pipe, a turn before a tee
    "enter_3d",  # postures and the roll joint
    "inspect",  # a camera's words, questions
    "exp_2b_detector",
    "exp_2c_clamp",  # loops
    "level",  # the accelerometer
    "climb",
}
"""Shipped missions that together use everything that missions of the robot use."""


Case = TypeVar("Case")


def thorough_but(few: Collection[Case], cases: Iterable[Case]) -> list[Any]:
    """Return the cases, those that are not among the few marked as thorough.

    Args:
        few: Cases that the default tests take; each is one of all.
        cases: All cases.
    """
    cases = list(cases)
    missing = [case for case in few if case not in cases]
    assert not missing, f"no such cases: {missing}"
    marked = []
    for case in cases:
        values = case if isinstance(case, tuple) else (case,)
        marks = () if case in few else pytest.mark.thorough
        marked.append(pytest.param(*values, marks=marks))
    return marked
