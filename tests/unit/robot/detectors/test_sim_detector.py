from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import mean, stdev
from typing import Any, Literal

import pytest

from pirate_sm.core.companion import Counting, Onlooker
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.geometry import Bend
from pirate_sm.core.loading import LoadedMission
from pirate_sm.robot.detectors.simple_detectors import TruePlaces
from pirate_sm.running.wiring import Order, load, prepare

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


def test_a_twin_says_how_far_the_words_are_off(tmp_path: Path) -> None:
    twin = tmp_path / "twin.yaml"
    twin.write_text("format: 1\nrobot: pirate_ii\nnoise: {detector: 0 mm}\n", "utf-8")
    number = {"noise.detector": "0 mm"}
    exact = [
        points(seed, **more)
        for seed in (1, 2)
        for more in ({"twin": str(twin)}, {"numbers": number})
    ]
    assert all(each == exact[0] for each in exact)
    assert points(1) != points(2)


def points(seed: int, **more: Any) -> object:
    """Where the words of a run with this seed are said."""
    companions = prepare(Order("mitre_bend", seed=seed, check=False, **more)).companions
    (sees,) = (each for each in companions if isinstance(each, TruePlaces))
    return sees._detector._points


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


def test_its_errors_are_those_of_the_seed(loaded: LoadedMission) -> None:
    profile, robot = loaded.loaded_robot.profile, loaded.loaded_robot.normal

    def errors(seed: int) -> list[float]:
        sees = TruePlaces(profile, robot, (Bend(1.0),), lambda: (), seed)
        return [error_m for _, error_m in sees._detector._words]

    assert errors(1) == errors(1) != errors(2)
    drawn = [error_m for seed in range(200) for error_m in errors(seed)]
    assert abs(mean(drawn)) < 0.001
    assert stdev(drawn) == pytest.approx(profile.simulation.noise.detector, rel=0.1)


def test_others_may_look_for_it_while_nothing_new_is_to_be_said(loaded: LoadedMission) -> None:
    places = [0.98 - 0.06 * wheel for wheel in range(6)]
    both, state = loaded.loaded_robot, driven(loaded, "normal", 1)
    sees = TruePlaces(both.profile, both.normal, (Bend(1.0),), lambda: places, seed=1)
    assert sees.due_s == 0.0
    assert sees.word_watch(state) is None, "it has not seen which way the robot drives"
    sees.look(state, 0.0)
    assert [word.word for word in sees.speak(0.0)] == ["close"]
    assert sees.speak(0.0) == ()

    watch = sees.word_watch(state)
    assert watch is not None
    assert (watch.places_m(), watch.due_s) == (places, pytest.approx(0.05))
    sees.relieve([(0.05, *places)], 0.1, None)
    assert sees.due_s == 0.1
    assert [at_s for at_s, *_ in sees.word_watch(state).seen] == [0.0, 0.05]
    assert sees.word_watch(driven(loaded, "normal", -1)) is None
