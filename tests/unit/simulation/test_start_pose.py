from __future__ import annotations

from collections.abc import Callable

import pytest

from pirate_sm.core.errors import UsageError

from .conftest import Driver, bend, straight

Place = Callable[..., Driver]


def test_a_robot_that_does_not_fit_is_refused(place: Place) -> None:
    with pytest.raises(UsageError, match="does not fit"):
        place(bend(), at=1.2)


def test_a_pipe_too_wide_to_clamp_is_refused(place: Place) -> None:
    with pytest.raises(UsageError, match="wide"):
        place(straight(diameter_m=0.2))
