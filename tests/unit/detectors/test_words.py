from __future__ import annotations

import itertools
from collections.abc import Iterable

import pytest

from pirate_sm.detectors.words import Detector, Point, Word

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
