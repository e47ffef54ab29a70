"""When the detector's words count for the place of a joint."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.mapping.looks import JointEnd, WordReader
from pirate_sm.robot.detectors.word_timing import words_of


@pytest.fixture
def reader() -> WordReader:
    return WordReader(words_of(load_robot(library.find_robot("pirate_ii")).profile))


def heard(reader: WordReader, *looks: tuple[str, float], travel: int = 1, driven: bool = True):
    """What is told while these words are valid, at these ways."""
    said = (SimpleNamespace(word=word, travel=travel, driven=driven) for word, _ in looks)
    told = [reader.look(look, way_m) for look, (_, way_m) in zip(said, looks, strict=True)]
    return [each for each in told if each is not None]


def test_each_word_of_a_bend_is_told_once(reader: WordReader) -> None:
    words = ["", "close", "close", "in", "in", "past", "past"]
    told = heard(reader, *((word, 0.1 * step) for step, word in enumerate(words)))
    assert [(it.end, it.wheel, it.passed_m) for it in told] == [
        (JointEnd.BEGINS, 0, -0.075),
        (JointEnd.INSIDE, 3, -0.04),
        (JointEnd.PASSED, 5, 0.06),
    ]


def test_backward_the_other_wheels_count(reader: WordReader) -> None:
    words = [("", 0.0), ("close", -0.1), ("in", -0.2)]
    told = heard(reader, *words, travel=-1)
    assert [(it.wheel, it.leads) for it in told] == [(5, -1), (2, -1)]


def test_a_word_that_held_when_the_robot_set_out_tells_nothing(reader: WordReader) -> None:
    assert heard(reader, ("", 0.0), ("close", 0.01), ("close", 0.1)) == []


def test_a_word_that_is_taken_back_tells_nothing(reader: WordReader) -> None:
    heard(reader, ("", 0.0), ("close", 0.1), ("in", 0.2))
    assert heard(reader, ("close", 0.2)) == []


def test_a_word_that_is_forgotten_and_said_anew_at_rest_tells_nothing(reader: WordReader) -> None:
    heard(reader, ("", 0.0), ("close", 0.1), ("", 0.4))
    assert heard(reader, ("close", 0.4), driven=False) == []


def test_words_without_a_point_change_nothing(reader: WordReader) -> None:
    told = heard(reader, ("", 0.0), ("close", 0.1), ("tee_ahead", 0.15), ("close", 0.2))
    assert [it.end for it in told] == [JointEnd.BEGINS]
