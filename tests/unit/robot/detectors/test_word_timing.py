from __future__ import annotations

import itertools
import random
from collections.abc import Iterable
from math import inf, nan

import pytest
from representative import thorough_but

from pirate_sm.core.events import DetectorWord
from pirate_sm.core.geometry import Bend
from pirate_sm.robot.detectors.word_timing import Point, Word, WordDetector

WORDS = (
    Word("near", Point(0, -0.06), Point(2, -0.06)),
    Word("within", Point(1, -0.02), Point(1, -0.02)),
    Word("through", Point(2, 0.06), Point(0, 0.06)),
)
LENGTHS = (0.0, 0.1, 0.2)


def detector(errors: tuple[float, ...] = (0.0, 0.0, 0.0), valid_for_s: float = 1e9) -> WordDetector:
    return WordDetector(WORDS, errors, (Bend(1.0),), valid_for_s)


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


@pytest.mark.parametrize("seed", thorough_but([0], range(12)))
def test_noise_on_the_places_never_says_the_words_of_the_way_back(seed: int) -> None:
    # The last word of the way back holds at first: the robot stands before the bend.
    forward = say(course(0.7, 1.5), noise_m=0.005, seed=seed)
    assert [word for word, _ in forward] == ["near", "within", "through"]
    assert [place for _, place in forward] == pytest.approx([0.94, 1.08, 1.26], abs=0.012)
    backward = say(course(1.6, 0.7), travel=-1, noise_m=0.005, seed=seed)
    assert [word for word, _ in backward] == ["near", "within", "through"]


@pytest.mark.parametrize("seed", thorough_but(range(3), range(12)))
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


def test_the_words_of_an_elbow_count_from_where_it_begins_and_where_it_ends() -> None:
    one, said = WordDetector(WORDS, (0.0,) * 3, (Bend(1.0, 0.05),), 1e9), []
    for step, place in enumerate(course(0.7, 1.5)):
        word = one.look(0.01 * step, [place - length for length in LENGTHS], 1)
        said += [(word.word, place)] if word is not None else []

    assert [word for word, _ in said] == ["near", "within", "through"]
    assert [place for _, place in said] == pytest.approx([0.89, 1.13, 1.31], abs=1.1e-3)


def test_the_last_word_of_a_bend_ends_and_the_next_bend_has_its_own() -> None:
    bends = (Bend(1.0), Bend(2.0))
    one, due = WordDetector(WORDS, (0.0,) * 3, bends, 1e9), []
    for step, place in enumerate(course(0.7, 2.4)):
        one.look(0.01 * step, [place - length for length in LENGTHS], 1)
        if one.due not in {word for word, _ in due[-1:]}:
            due.append((one.due, place))

    words = ["", "near", "within", "through"]
    assert [word for word, _ in due] == words + words
    places = [0.94, 1.08, 1.26, 1.51, 1.94, 2.08, 2.26]
    assert [place for _, place in due[1:]] == pytest.approx(places, abs=1.1e-3)


def test_a_word_stays_until_its_wheel_is_clearly_before_its_point() -> None:
    one = detector()
    for step, place in enumerate([*course(0.9, 0.95), 0.931]):
        one.look(0.5 * step, [place - length for length in LENGTHS], 1)
    assert one.due == "near"
    one.look(100.0, [0.929, 0.829, 0.729], 1)
    assert one.due == ""
    one.look(101.0, [0.939, 0.839, 0.739], 1)
    assert one.due == ""


def standing(one: WordDetector, place: float, travel: int = 1) -> list[float]:
    """Show the wheels where they stand while they are driven; return their places."""
    places = [place - length for length in LENGTHS]
    one.look(1.0, places, travel)
    return places


@pytest.mark.parametrize(
    ("place", "travel", "word"),
    [
        (0.5, 0, (-1, "", 2.0, 0.0, inf)),
        (0.5, 1, (-1, "", 2.0, 0.0, inf)),
        (0.95, 1, (2, "near", 2.0, 1.0, 1.0)),
        (1.3, 1, (0, "through", 2.0, 1.0, 1.0)),
        (1.11, -1, (1, "within", 2.0, 1.0, 1.0)),
    ],
)
def test_what_it_knows_lets_others_look_for_it(
    place: float, travel: int, word: tuple[object, ...]
) -> None:
    one = detector((0.001, 0.002, 0.003), valid_for_s=2.0)
    places = standing(one, place, travel)

    watch = one.watch(lambda: places, 1.05, travel)

    assert watch is not None
    forward = ((2, -0.057), (1, 0.022), (0, 0.061))
    backward = ((0, -0.057), (1, 0.022), (2, 0.061))
    assert watch.points == tuple(
        (wheel, pytest.approx(off_m)) for wheel, off_m in (forward if travel > 0 else backward)
    )
    assert (watch.places_m(), watch.due_s, watch.every_s) == (places, 1.05, 0.05)
    assert list(watch.seen) == [(1.0, *places)]
    assert (watch.driven, watch.direction, watch.bends) == (travel != 0, travel, (Bend(1.0),))
    assert watch[-5:] == word


@pytest.mark.parametrize(("seen", "now"), [(1, 0), (0, 1), (1, -1)])
def test_nobody_looks_for_it_once_the_wheels_are_driven_otherwise(seen: int, now: int) -> None:
    one = detector()
    standing(one, 0.5, 1)
    standing(one, 0.5, seen)

    assert one.watch(list, 2.0, now) is None


def test_others_may_look_for_it_while_it_stands() -> None:
    one = detector()
    standing(one, 0.95, 1)
    standing(one, 0.95, 0)

    watch = one.watch(list, 2.0, 0)
    assert watch is not None
    assert (watch.driven, watch.direction, watch.name) == (False, 1, "near")


def test_a_bend_that_is_passed_is_passed_wherever_other_wheels_seem_to_be() -> None:
    one = detector()
    one.look(0.0, [1.6, 1.1, 1.4], 1)
    assert one.due == ""


def test_nobody_looks_for_it_while_the_word_that_holds_must_not_be_said() -> None:
    one = detector()
    one.look(1.0, [0.95, 0.85, 0.75], 1, frozenset({"near"}))

    assert one.watch(list, 2.0, 1) is None


@pytest.mark.parametrize(
    ("said_s", "again"), [(None, [True, False, False]), (1.5, [False, False, True])]
)
def test_looks_of_others_count_as_its_own(said_s: float | None, again: list[bool]) -> None:
    one = detector(valid_for_s=0.5)
    places = standing(one, 0.95)
    looks = [(1.3, 0.98, 0.88, 0.78), (1.6, 1.01, 0.91, 0.81)]

    one.relieve(looks, said_s)

    watch = one.watch(lambda: places, 2.0, 1)
    assert watch is not None
    assert list(watch.seen) == [*looks]  # what was seen at 1 s is too old by now
    said = [one.look(at_s, None, 1) for at_s in (1.7, 1.74, 1.75)]
    assert said == [DetectorWord("near", 0.5) if each else None for each in again]


def test_a_wheel_on_its_point_is_there() -> None:
    """Numbers without rounding: a word begins on its point, and ends a quarter of a metre on."""
    words = (Word("at", Point(0, 0.0), Point(0, 0.0)),)
    for place, due in ((0.0, "at"), (-0.001, ""), (0.249, "at"), (0.25, "")):
        one = WordDetector(words, (0.0,), (Bend(0.0),), 1.0)
        one.look(0.0, [place], 1)
        assert one.due == due


@pytest.mark.parametrize(("travel", "end"), [(1, (0.7, 1.7)), (-1, (1.7, 0.7))])
def test_a_word_begins_and_ends_no_later_when_looks_are_seldom_far_from_it(
    travel: int, end: tuple[float, float]
) -> None:
    often, seldom, due_s, looks = detector(valid_for_s=1e9), detector(valid_for_s=1e9), 0.0, 0
    for step, place in enumerate(course(*end)):  # 1 mm in 20 ms
        now_s, seen = 0.02 * step, [place - length for length in LENGTHS]
        often.look(now_s, seen, travel)
        if now_s >= due_s - 1e-9:
            seldom.look(now_s, seen, travel)
            due_s, looks = now_s + seldom.wait_s(0.05), looks + 1
        assert seldom.due == often.due or now_s - due_s <= 0.05

    assert looks < 200  # of 400 at 0.05 s


def test_a_word_is_not_told_later_of_a_robot_that_starts_next_to_its_point() -> None:
    often, seldom, due_s, late = detector(), detector(), 0.0, 0
    for step in range(130):
        now_s = 0.01 * step
        place = 0.939 + 0.5 * 0.25 * max(0.0, now_s - 0.4) ** 2  # "near" is at 0.94
        seen = [place - length for length in LENGTHS]
        often.look(now_s, seen, 1)
        if now_s >= due_s - 1e-9:
            seldom.look(now_s, seen, 1)
            due_s = now_s + seldom.wait_s(0.1)
        late += often.due == "near" and seldom.due == ""
    assert seldom.due == "near"
    assert late <= 5  # of 0.01 s


@pytest.mark.parametrize(("valid_for_s", "wait_s"), [(1.0, 0.15), (0.2, 0.1), (0.05, 0.05)])
def test_looks_are_seldom_while_no_wheel_is_driven_but_words_are_repeated(
    valid_for_s: float, wait_s: float
) -> None:
    resting = detector(valid_for_s=valid_for_s)
    resting.look(0.0, [0.95, 0.85, 0.75], 0)

    assert resting.wait_s(0.1) == pytest.approx(wait_s)


@pytest.mark.parametrize(
    ("first_m", "wait_s"),
    [
        (0.5, 0.15),
        (0.918, 0.12),  # 22 mm before the first word, and it would hold 10 mm earlier
        (0.93, 0.05),
        (1.102, 0.12),  # 22 mm beyond the second one
        (1.168, 0.12),  # 22 mm before the first one is forgotten
        (1.532, 0.12),  # 22 mm beyond where the last one is
        (2.0, 0.15),
    ],
)
def test_the_next_look_at_driven_wheels_is_before_one_can_be_where_a_word_begins_or_ends(
    first_m: float, wait_s: float
) -> None:
    driven = detector()
    driven.look(0.0, [first_m - length for length in LENGTHS], 1)

    assert driven.wait_s(0.1) == pytest.approx(wait_s)


def test_where_words_begin_does_not_matter_before_the_first_look() -> None:
    one = detector()
    one.see(0.0, [0.9, 0.8, 0.7], 1, 0.0)

    assert one.wait_s(0.1) == pytest.approx(0.15)
