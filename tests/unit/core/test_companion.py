from __future__ import annotations

from typing import Any

import pytest

from pirate_sm.core.companion import entered
from pirate_sm.core.errors import UsageError


class Plain:
    """A companion with nothing to open."""

    due_s, listening = 0.0, False

    def react(self, effects: Any, now_s: float) -> None: ...

    def speak(self, now_s: float) -> tuple[()]:
        return ()


class Door(Plain):
    """A companion that is open while it is entered."""

    def __init__(self, fault: str = "") -> None:
        self.open, self._fault = False, fault

    def __enter__(self) -> Door:
        if self._fault:
            raise UsageError(self._fault)
        self.open = True
        return self

    def __exit__(self, *_: object) -> None:
        self.open = False


def test_what_can_be_opened_is_open_in_between() -> None:
    door = Door()
    with entered([Plain(), door]):
        assert door.open
    assert not door.open


def test_what_was_opened_is_closed_where_the_next_one_fails() -> None:
    door = Door()
    with pytest.raises(UsageError, match="in use"), entered([door, Door("in use")]):
        pass
    assert not door.open
