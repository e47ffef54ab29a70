from __future__ import annotations

import json
from dataclasses import replace
from math import nan
from pathlib import Path
from shutil import copytree

import pytest

import pirate_sm
from pirate_sm.checking.mission.check_mission import check_mission
from pirate_sm.core._engine.robot.robot_spec import WordCondition
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import compile_condition
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.simple_detectors import SignalWords
from pirate_sm.running.wiring import Order, load


class Robot:
    """A robot with two words on two of its signals, and what it shows."""

    def __init__(self, held_s: float = 0.0) -> None:
        loaded = load(Order("mitre_bend"))
        spec, names = loaded.robot, loaded.robot.vocabulary
        conditions = (
            WordCondition("close", compile_condition("gamma_1 > 10 deg", names), held_s),
            WordCondition("past", compile_condition("gamma_2 > 10 deg", names), held_s),
        )
        self.spec: RobotSpec = replace(spec, word_conditions=conditions)
        self.state, _ = Engine(spec, loaded.program, nominal=True).start()
        self.detector = SignalWords(self.spec, 1.0)

    def shows(self, now_s: float, gamma_1: float, gamma_2: float) -> list[tuple[str, float]]:
        """Return what the detector says of these angles, rad."""
        numbers = list(self.state.sensing.numbers)
        for name, value in (("gamma_1", gamma_1), ("gamma_2", gamma_2)):
            numbers[self.spec.vocabulary.numbers.index(name)] = value
        sensing = self.state.sensing._replace(numbers=tuple(numbers))
        state: EngineState = self.state._replace(sensing=sensing)
        assert self.detector.look(state, now_s) == ()
        said = self.detector.speak(now_s)
        assert not any(each.by for each in said)
        return [(each.word, each.valid_for_s) for each in said]


def test_a_word_is_said_while_its_condition_holds_and_repeated_before_it_expires() -> None:
    robot = Robot()
    said = [robot.shows(0.1 * turn, 1.0, 0.0) for turn in range(11)]
    assert said == [[("close", 1.0)], *[[]] * 4, [("close", 1.0)], *[[]] * 4, [("close", 1.0)]]
    assert robot.shows(1.1, 0.0, 0.0) == []


def test_of_several_words_the_last_counts() -> None:
    assert Robot().shows(0.0, 1.0, 1.0) == [("past", 1.0)]


@pytest.mark.parametrize(("gamma_1", "gamma_2"), [(nan, 0.0), (1.0, nan), (nan, nan)])
def test_unknown_signals_say_nothing(gamma_1: float, gamma_2: float) -> None:
    assert Robot().shows(0.0, gamma_1, gamma_2) == []


def test_a_later_word_needs_no_knowledge_of_earlier_ones() -> None:
    assert Robot().shows(0.0, nan, 1.0) == [("past", 1.0)]


def test_a_condition_must_hold_without_interruption() -> None:
    robot = Robot(held_s=0.1)
    assert robot.shows(0.0, 1.0, 0.0) == []
    assert robot.shows(0.05, nan, 0.0) == []
    assert robot.shows(0.1, 1.0, 0.0) == []
    assert robot.shows(0.15, 0.0, 0.0) == []
    assert robot.shows(0.2, 1.0, 0.0) == []
    assert robot.shows(0.3, 1.0, 0.0) == [("close", 1.0)]


def test_a_word_that_comes_again_is_said_again() -> None:
    robot = Robot()
    assert robot.shows(0.0, 1.0, 0.0)
    assert robot.shows(0.05, 0.0, 0.0) == []
    assert robot.shows(0.1, 1.0, 0.0) == [("close", 1.0)]


def test_the_first_look_is_at_once_and_the_next_mission_may_have_other_conditions() -> None:
    robot = Robot()
    assert robot.detector.due_s == 0.0
    robot.detector.restart(replace(robot.spec, word_conditions=()))
    assert robot.shows(0.0, 1.0, 1.0) == []
    assert robot.detector.due_s == pytest.approx(0.05)


def test_a_mission_goes_on_by_a_condition_that_stands_in_yaml_alone(tmp_path: Path) -> None:
    newt = Path(__file__).resolve().parents[3] / "robots" / "newt"
    copytree(newt, tmp_path / "newt")
    profile = tmp_path / "newt" / "profile.yaml"
    text = profile.read_text("utf-8")
    begin, end = text.index("    near:\n"), text.index("simulation:\n")
    word = "    near: {when: way > 100 mm, held: 100 ms}\n\n"
    profile.write_text(text[:begin] + word + text[end:], "utf-8")

    run = pirate_sm.run(tmp_path / "newt" / "patrol.yaml", detector="signals", seed=1)

    assert run.outcome == "succeeded", run.message
    # The check knows that such a word needs no bend.
    pipe = {"format": 1, "diameter": "95 mm", "segments": [{"straight": "2 m"}]}
    straight = tmp_path / "straight.yaml"
    straight.write_text(json.dumps(pipe | {"pipe": "straight", "start": {"at": "700 mm"}}))
    assert not check_mission(tmp_path / "newt" / "patrol.yaml", pipe=str(straight)).findings
    run = pirate_sm.run(tmp_path / "newt" / "patrol.yaml", detector="signals", pipe=str(straight))
    assert run.outcome == "succeeded", run.message
    with pytest.raises(UsageError, match="no word of the profile has points"):
        pirate_sm.run(tmp_path / "newt" / "patrol.yaml", detector="sim")
    with pytest.raises(UsageError, match="no word of newt has a condition"):
        pirate_sm.run(newt / "patrol.yaml", detector="signals")
