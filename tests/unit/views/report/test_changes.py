from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.views.report.changes import changes

LEAVES = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=2)
)
DATA = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from("abc"), inner, max_size=3)
    ),
    max_leaves=12,
)


def applied(before: Any, found: list[Any]) -> Any:
    """What `apply` of the page's script makes of it."""
    root = {"data": deepcopy(before)}
    for change in found:
        path = change[0]
        holder: Any = root
        for key in path[:-1]:
            holder = holder[key]
        if len(change) == 2:
            holder[path[-1]] = change[1]
        else:
            holder[path[-1]][change[1] :] = change[2]
    return root["data"]


@given(DATA, DATA)
def test_changes_turn_one_value_into_the_other(before: Any, after: Any) -> None:
    found = json.loads(json.dumps([*changes({"data": before}, {"data": after})]))

    assert applied(before, found) == after


@given(st.lists(st.integers()), st.lists(st.integers(), min_size=1))
def test_what_is_appended_is_all_that_is_sent(before: list[int], more: list[int]) -> None:
    (change,) = changes({"values": before}, {"values": before + more})

    assert change == (["values"], len(before), more)


def test_equal_values_have_no_changes() -> None:
    data = {"clocks": [[1, 2], [3]], "scene": None}

    assert [*changes(data, deepcopy(data))] == []
