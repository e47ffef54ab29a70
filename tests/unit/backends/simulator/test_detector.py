from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable

import pytest

from pirate_sm.backends.simulator.detector import (
    Detector,
    Point,
    Surroundings,
    Vee,
    Word,
    segment_of,
)
from pirate_sm.backends.simulator.geometry import Pipe

from .conftest import DIAMETER_M, Driver, bend, straight

WORDS = (
    Word("near", Point(0, -0.06), Point(2, -0.06)),
    Word("within", Point(1, -0.02), Point(1, -0.02)),
    Word("through", Point(2, 0.06), Point(0, 0.06)),
)
LENGTHS = (0.0, 0.1, 0.2)


def say(
    places: Iterable[float], errors: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> list[tuple[str, float]]:
    """What is said with the first wheel at these places, each with the place."""
    detector = Detector(WORDS, errors, (1.0,), valid_for_s=1e9)
    said = []
    for step, place in enumerate(places):
        word = detector.look(0.1 * step, [place - length for length in LENGTHS])
        if word is not None:
            said.append((word.word, place))
    return said


def course(first: float, last: float) -> list[float]:
    count = round(abs(last - first) * 1000)
    return [first + (last - first) * i / count for i in range(count + 1)]


def test_words_come_in_order_at_their_places() -> None:
    said = say(course(0.7, 1.5))
    assert [word for word, _ in said] == ["near", "within", "through"]
    assert [place for _, place in said] == pytest.approx([0.94, 1.08, 1.26], abs=1.1e-3)


def test_backward_it_is_mirrored() -> None:
    said = say(course(1.6, 0.7))
    assert [word for word, _ in said] == ["near", "within", "through"]
    # The last wheel, 0.2 behind the first, leads: it is 60 mm before the crossing at 1.26.
    assert [place for _, place in said] == pytest.approx([1.26, 1.12, 0.94], abs=1.1e-3)


def test_an_error_shifts_the_places() -> None:
    said = say(course(0.7, 1.5), errors=(0.005, 0.0, -0.005))
    assert [place for _, place in said] == pytest.approx([0.935, 1.08, 1.265], abs=1.1e-3)


def test_it_is_silent_until_the_robot_moves_and_after_it_has_gone() -> None:
    assert say([0.97] * 50) == []
    said = say(course(0.7, 2.5))
    assert said[-1][0] == "through"


def test_a_part_that_bends_back_does_not_turn_the_travel() -> None:
    detector = Detector(WORDS, (0.0,) * 3, (1.0,), valid_for_s=1e9)
    for place in course(0.7, 1.1):
        detector.look(0.0, [place, place - 0.1, place - 0.2])
    assert detector.look(0.0, [1.1, 1.0, 0.85]) is None  # only the last wheel has moved
    said = [detector.look(0.0, [p, p - 0.1, p - 0.2]) for p in course(1.1, 1.4)]
    assert [word.word for word in said if word] == ["through"]


def test_a_word_that_holds_is_said_again_while_valid() -> None:
    detector = Detector(WORDS, (0.0,) * 3, (1.0,), valid_for_s=1.0)
    for place in course(0.7, 0.95):
        detector.look(0.0, [place, place - 0.1, place - 0.2])
    times = [0.1 * i for i in range(30) if detector.look(0.1 * i, [0.95, 0.85, 0.75])]
    assert times
    assert max(b - a for a, b in itertools.pairwise(times)) <= 0.6


@pytest.mark.parametrize(
    ("first", "segment"), [(0.7, "Straight"), (1.2, "Joint"), (1.9, "Straight"), (2.5, "Out")]
)
def test_the_segment_is_where_the_robot_is(first: float, segment: str) -> None:
    arcs = [first - 0.1 * i for i in range(4)]
    assert segment_of(Pipe(bend()), arcs) == segment


def test_the_diameter_is_reported_once_a_part_is_clamped(place: Callable[..., Driver]) -> None:
    robot = place(straight(), clamped=0.0)
    surroundings = Surroundings({"front": Vee(1, 0.09, (0, 1, 2))}, 0.024)
    first = surroundings.look(robot.world, robot.world.values("arc"))
    assert first is not None
    assert first.segment == "Straight"
    assert math.isnan(first.diameter_m)
    assert surroundings.look(robot.world, robot.world.values("arc")) is None
    robot.clamp(1, 2, 3, 4)
    robot.run(7.0)
    report = surroundings.look(robot.world, robot.world.values("arc"))
    assert report is not None
    assert report.diameter_m == pytest.approx(DIAMETER_M, abs=2e-3)


def test_pitch_is_that_of_the_leg(place: Callable[..., Driver]) -> None:
    robot = place(bend(tilt_rad=math.radians(28)), at=1.8)
    report = Surroundings({}, 0.024).look(robot.world, robot.world.values("arc"))
    assert report is not None
    assert report.pitch_rad == pytest.approx(math.radians(28))
