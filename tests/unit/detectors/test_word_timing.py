from __future__ import annotations

import itertools
import random
from collections.abc import Iterable
from math import nan

import pytest

from pirate_sm.detectors.word_timing import Detector, Point, Word
from pirate_sm.geometry.joints import Bend

WORDS = (
    Word("near", Point(0, -0.06), Point(2, -0.06)),
    Word("within", Point(1, -0.02), Point(1, -0.02)),
    Word("through", Point(2, 0.06), Point(0, 0.06)),
)
LENGTHS = (0.0, 0.1, 0.2)


def detector(errors: tuple[float, ...] = (0.0, 0.0, 0.0), valid_for_s: float = 1e9) -> Detector:
    return Detector(WORDS, errors, (Bend(1.0),), valid_for_s)


def say(
    places: Iterable[float],
    errors: tuple[float, ...] = (0.0, 0.0, 0.0),
    *,
    travel: int = 1,
    noise_m: float = 0.0,
    seed: int = 0,
) -> list[tuple[str, float]]:
    """What is said with the first wheel at these places, each with the place."""
    one, chance = detector(errors), random.Random(seed)
    said = []
    for step, place in enumerate(places):
        seen = [place - length + chance.gauss(0.0, noise_m) for length in LENGTHS]
        word = one.look(0.01 * step, seen, travel)
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


def test_belief_in_a_word_waits_until_it_is_not_barred_any_more() -> None:
    one, said, due = detector(), [], {}
    for step, place in enumerate(course(0.7, 1.5)):
        barred = frozenset({"through"}) if place < 1.4 else frozenset[str]()
        word = one.look(0.01 * step, [place - each for each in LENGTHS], 1, barred)
        due[round(place, 3)] = one.due
        said += [(word.word, round(place, 3))] if word is not None else []

    assert [word for word, _ in said] == ["near", "within", "through"]
    assert said[-1][1] == pytest.approx(1.4, abs=1.1e-3)
    assert (due[1.2], due[1.3], due[1.45]) == ("within", "through", "through")


def test_backward_it_is_mirrored() -> None:
    said = say(course(1.6, 0.7), travel=-1)
    assert [word for word, _ in said] == ["near", "within", "through"]
    # The last wheel, 0.2 behind the first, leads: it is 60 mm before the crossing at 1.26.
    assert [place for _, place in said] == pytest.approx([1.26, 1.12, 0.94], abs=1.1e-3)


def test_an_error_shifts_the_places() -> None:
    said = say(course(0.7, 1.5), errors=(0.005, 0.0, -0.005))
    assert [place for _, place in said] == pytest.approx([0.935, 1.08, 1.265], abs=1.1e-3)


def test_it_is_silent_until_wheels_are_driven_and_after_the_robot_has_gone() -> None:
    assert say([0.97] * 50, travel=0) == []
    said = say(course(0.7, 2.5))
    assert said[-1][0] == "through"


@pytest.mark.parametrize("seed", range(12))
def test_noise_on_the_places_never_says_the_words_of_the_way_back(seed: int) -> None:
    # The last word of the way back holds at first: the robot stands before the bend.
    forward = say(course(0.7, 1.5), noise_m=0.005, seed=seed)
    assert [word for word, _ in forward] == ["near", "within", "through"]
    assert [place for _, place in forward] == pytest.approx([0.94, 1.08, 1.26], abs=0.012)
    backward = say(course(1.6, 0.7), travel=-1, noise_m=0.005, seed=seed)
    assert [word for word, _ in backward] == ["near", "within", "through"]


@pytest.mark.parametrize("seed", range(12))
def test_a_standing_robot_keeps_its_word_whatever_its_places_seem_to_be(seed: int) -> None:
    one, chance = detector(), random.Random(seed)
    for step, place in enumerate(course(0.7, 1.05)):
        one.look(0.01 * step, [place - length for length in LENGTHS], 1)
    for step in range(200):  # 30 mm before the next word's point
        noisy = [1.05 - length + chance.gauss(0.0, 0.005) for length in LENGTHS]
        assert one.look(3.6 + 0.05 * step, noisy, 0) is None


def test_parts_that_bend_do_not_turn_the_travel() -> None:
    one = detector()
    for step, place in enumerate(course(0.7, 1.1)):
        one.look(0.01 * step, [place, place - 0.1, place - 0.2], 1)
    assert one.look(5.0, [1.1, 1.0, 0.85], 0) is None  # only the last wheel has moved
    said = [
        one.look(5.1 + 0.01 * i, [p, p - 0.1, p - 0.2], 1) for i, p in enumerate(course(1.1, 1.4))
    ]
    assert [word.word for word in said if word] == ["through"]


def test_the_way_back_has_its_own_words_as_soon_as_the_wheels_are_driven_back() -> None:
    one = detector()
    for step, place in enumerate(course(0.7, 1.1)):
        one.look(0.01 * step, [place - length for length in LENGTHS], 1)
    # The last wheel has been on this side of the crossing all the time.
    turned = one.look(5.0, [1.1, 1.0, 0.9], -1)
    assert turned is not None
    assert turned.word == "within"


def test_nothing_is_said_where_the_place_of_the_words_wheel_is_unknown() -> None:
    one = detector()
    for step, place in enumerate(course(0.7, 1.2)):
        one.look(0.01 * step, [place, nan, nan], 1)
        assert one.look(0.01 * step + 0.005, [place, nan, nan], 1) is None


def test_a_word_whose_own_wheel_is_known_is_said_if_no_later_one_can_hold() -> None:
    one = detector()
    said = []
    for step, place in enumerate(course(0.7, 1.5)):
        word = one.look(0.01 * step, [nan, nan, place - 0.2], 1)
        said += [(word.word, place)] if word else []
    assert [word for word, _ in said] == ["through"]


def test_a_word_ceases_when_its_place_becomes_unknown() -> None:
    one = detector(valid_for_s=1.0)
    for step, place in enumerate(course(0.7, 0.95)):
        one.look(0.01 * step, [place - length for length in LENGTHS], 1)
    assert [one.look(3.0 + 0.1 * i, [0.95, nan, 0.75], 0) for i in range(30)] == [None] * 30
    again = one.look(6.1, [0.95, 0.85, 0.75], 0)
    assert again is not None
    assert again.word == "near"


def test_a_word_that_holds_is_said_again_while_valid() -> None:
    one = detector(valid_for_s=1.0)
    for step, place in enumerate(course(0.7, 0.95)):
        one.look(0.01 * step, [place - length for length in LENGTHS], 1)
    times = [3 + 0.1 * i for i in range(30) if one.look(3 + 0.1 * i, [0.95, 0.85, 0.75], 0)]
    assert times
    assert max(b - a for a, b in itertools.pairwise(times)) <= 0.6
