from __future__ import annotations

from math import inf

import pytest

from pirate_sm.core.effects import Ended, Log
from pirate_sm.core.events import DetectorWord
from pirate_sm.robot.detectors.simple_detectors import WordKeys


class Keyboard:
    keys = ""

    def pressed(self) -> str:
        keys, self.keys = self.keys, ""
        return keys


@pytest.mark.parametrize(
    ("keys", "words"), [("", ()), ("a", ("near",)), ("B", ("far",)), ("xbca", ("far", "near"))]
)
def test_a_key_says_its_word(keys: str, words: tuple[str, ...]) -> None:
    keyboard = Keyboard()
    companion = WordKeys(keyboard, ("near", "far"), 1.5)
    keyboard.keys = keys
    assert companion.due_s == 0.0
    assert companion.speak(2.0) == tuple(DetectorWord(word, 1.5) for word in words)
    assert companion.due_s == pytest.approx(2.05)


def test_the_keys_are_on_offer_until_the_end() -> None:
    companion = WordKeys(Keyboard(), ("near", "far"), 1.0)
    assert companion.offered == "[a] near  [b] far"
    companion.react((Log("info", "x"),), 1.0)
    assert companion.listening
    companion.react((Ended("succeeded", "done"),), 2.0)
    assert (companion.listening, companion.due_s) == (False, inf)
