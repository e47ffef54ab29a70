from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import pytest

from pirate_sm.companion import Counting, Onlooker
from pirate_sm.detectors.sim_detector import TruePlaces
from pirate_sm.engine.engine import Engine
from pirate_sm.engine.state import EngineState
from pirate_sm.geometry.joints import Bend
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.wiring import Order, load

Polarity = Literal["normal", "mirrored"]


@pytest.fixture(scope="module")
def loaded() -> LoadedMission:
    return load(Order("mitre_bend"))


def driven(loaded: LoadedMission, polarity: Polarity, way: int) -> EngineState:
    """The engine's state with every wheel driven, in the setpoints of this polarity."""
    robot = loaded.loaded_robot.oriented(polarity)
    state, _ = Engine(robot, loaded.program, nominal=True).start()
    values = list(state.robot.values)
    for wheel in robot.wheels:
        values[wheel.slot] = way * (1.0 if wheel.metres_per_rad > 0 else -1.0)
    return state._replace(robot=state.robot._replace(values=tuple(values)))


def say(
    sees: TruePlaces, places: list[float], state: EngineState, first_m: Sequence[float]
) -> list[str]:
    said = []
    for step, first in enumerate(first_m):
        places[:] = [first - 0.06 * wheel for wheel in range(6)]
        sees.look(state, 0.05 * step)
        said += [word.word for word in sees.speak(0.05 * step)]
    return list(dict.fromkeys(said))


@pytest.mark.parametrize("polarity", ["normal", "mirrored"])
def test_the_words_follow_the_setpoints_in_force_in_either_polarity(
    loaded: LoadedMission, polarity: Polarity
) -> None:
    places = [0.0] * 6
    robot = loaded.loaded_robot.oriented(polarity)
    sees = TruePlaces(loaded.loaded_robot.profile, robot, (Bend(1.0),), lambda: places, seed=1)
    there = [0.7 + 0.005 * step for step in range(160)]
    words = ["close", "in", "past"]
    assert say(sees, places, driven(loaded, polarity, 1), there) == words
    sees = TruePlaces(loaded.loaded_robot.profile, robot, (Bend(1.0),), lambda: places, seed=1)
    assert say(sees, places, driven(loaded, polarity, -1), [p + 0.2 for p in there[::-1]]) == words


def test_the_next_mission_may_have_another_polarity(loaded: LoadedMission) -> None:
    places = [0.0] * 6
    both = loaded.loaded_robot
    sees = TruePlaces(both.profile, both.normal, (Bend(1.0),), lambda: places, seed=1)
    assert isinstance(sees, Counting)
    assert isinstance(sees, Onlooker)
    sees.restart(both.mirrored)
    there = [0.7 + 0.005 * step for step in range(160)]
    assert say(sees, places, driven(loaded, "mirrored", 1), there) == ["close", "in", "past"]


@pytest.mark.thorough
def test_its_errors_are_those_of_the_seed(loaded: LoadedMission) -> None:
    def first_word(seed: int) -> float:
        places = [0.0] * 6
        both = loaded.loaded_robot
        sees = TruePlaces(both.profile, both.normal, (Bend(1.0),), lambda: places, seed)
        state = driven(loaded, "normal", 1)
        for step in range(3000):
            places[:] = [0.7 + 0.0002 * step - 0.06 * wheel for wheel in range(6)]
            sees.look(state, 0.002 * step)
            if sees.speak(0.002 * step):
                return places[0]
        raise AssertionError("nothing was said")

    assert first_word(1) == first_word(1)
    found = [first_word(seed) for seed in range(8)]
    assert len(set(found)) > 4
    assert found == pytest.approx([0.94] * 8, abs=0.02)
