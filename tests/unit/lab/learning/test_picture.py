from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.palette import DAY

from .conftest import act, made


def share(image: Any, role: str) -> float:
    """How much of a picture has this colour."""
    colour = [int(DAY[role][place : place + 2], 16) for place in (1, 3, 5)]
    return float(np.mean(np.all(image == colour, axis=2)))


@pytest.mark.parametrize(
    "options",
    [{}, pytest.param({"pipe": "tests/pipes/house.yaml"}, marks=pytest.mark.thorough)],
    ids=["planar", "round"],
)
def test_a_picture_shows_the_robot_in_its_pipe_and_what_holds(options: dict[str, Any]) -> None:
    environment = made(render_mode="rgb_array", **options)
    environment.reset(seed=1)
    before = environment.render()

    act(environment, "ClampFront")
    after = environment.render()

    assert before.shape == after.shape == (360, 640, 3)
    assert before.dtype == np.uint8
    assert share(before, "wall" if not options else "bore") > 0.001
    assert share(before, "body") + share(before, "held") > 0.01
    assert share(after, "held") > share(before, "held")
    assert not np.array_equal(before, after)
    environment.close()


def test_without_a_render_mode_there_is_no_picture() -> None:
    environment = made()
    environment.reset(seed=1)

    assert environment.unwrapped.render() is None
    environment.close()


def test_a_render_mode_that_is_not_there_is_refused_with_the_one_that_is() -> None:
    from pirate_sm.lab.learning.environment import InPipe  # noqa: PLC0415 - loads the learning

    with pytest.raises(UsageError, match="there is no render mode 'human'"):
        InPipe(render_mode="human")
    environment = InPipe(render_mode="rgb_array")
    with pytest.raises(UsageError, match="reset the environment"):
        environment.render()
