"""Where a robot in space was, in the messages for viewers."""

from __future__ import annotations

from pirate_sm.core.events import InSpace
from pirate_sm.running.recording.viewers.viewer_messages import (
    columns_in_space,
    space_of,
    values_in_space,
)

WHEELS = ("first", "second")
SPACE = InSpace((0.01, -0.02), (0.1, 0.2, 0.3))


def test_what_is_written_is_read_again() -> None:
    content = dict(zip(columns_in_space(WHEELS), values_in_space(SPACE), strict=True))
    assert space_of({"known": True, **content}, WHEELS) == SPACE


def test_a_message_of_a_robot_in_a_plane_has_nothing_of_it() -> None:
    assert space_of({"known": True, "first_x_m": 1.0}, WHEELS) is None


def test_a_message_with_a_gap_has_nothing_of_it() -> None:
    content = dict(zip(columns_in_space(WHEELS), values_in_space(SPACE), strict=True))
    del content["second_z_m"]
    assert space_of(content, WHEELS) is None
