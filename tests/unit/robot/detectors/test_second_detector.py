from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

import pirate_sm
from pirate_sm.core.companion import entered
from pirate_sm.core.effects import Detected, Effect, Log
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import DetectorWord, Event, FaultReport, OutsideNumber
from pirate_sm.robot.detectors.registry import SecondDetector
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare


def test_a_second_detector_is_logged_and_changes_nothing() -> None:
    def words(also: str | None) -> tuple[list[tuple[str, float]], list[str]]:
        ready = prepare(Order("mitre_bend", seed=3, also=also))
        heard: list[tuple[str, float]] = []
        logged: list[str] = []

        class Watching:
            due_s = float("inf")
            listening = False

            def react(self, effects, now_s) -> None:
                heard.extend((e.word, now_s) for e in effects if isinstance(e, Detected))

            def speak(self, now_s):
                return ()

        class Screen:
            def see(self, effects, now_s) -> None:
                logged.extend(e.message for e in effects if isinstance(e, Log))

        run = MissionRun(
            ready.engine, ready.backend, companions=[*ready.companions, Watching()],
            observers=[Screen()],
        )  # fmt: skip
        assert run.execute().ended.outcome == "succeeded"
        return heard, [line for line in logged if line.startswith("also")]

    alone, silent = words(None)
    beside, logged = words("odometry")

    assert [word for word, _ in beside] == [word for word, _ in alone]
    assert silent == []
    # That the bend is passed it says half a second later, when the run has ended.
    words_beside = [f"also odometry: {word}" for word in ("close", "in")]
    assert list(dict.fromkeys(logged)) == words_beside


class Other:
    """A detector that says what a test wants, and notes what it is asked."""

    def __init__(self, *said: Sequence[Event], listening: bool = False) -> None:
        self.due_s, self.listening = 3.5, listening
        self.asked: list[tuple[Any, ...]] = []
        self._said = iter(said)

    def __enter__(self) -> None:
        self.asked.append(("enter",))

    def __exit__(self, *_: object) -> None:
        self.asked.append(("exit",))

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        self.asked.append(("react", effects, now_s))

    def speak(self, now_s: float) -> Sequence[Event]:
        self.asked.append(("speak", now_s))
        return next(self._said)


class Seeing(Other):
    """One that looks at the state, and counts."""

    def look(self, state: Any, now_s: float) -> Sequence[Log]:
        self.asked.append(("look", state, now_s))
        return (Log("info", "I look"),)

    def restart(self, robot: Any) -> None:
        self.asked.append(("restart", robot))


FAULT = FaultReport("vision.dark", "it is dark")
CLOSE, IN = DetectorWord("close", 1.0), DetectorWord("in", 1.0)
STATE: Any = "a state"
ROBOT: Any = "a robot"


def test_a_word_is_logged_when_it_begins_and_a_fault_each_time() -> None:
    said = ((0.0, [CLOSE]), (0.5, [CLOSE]), (1.5, [CLOSE]), (2.6, [CLOSE, OutsideNumber("x", 1.0)]),
            (2.7, [IN]), (2.8, [CLOSE]), (2.9, [FAULT, FAULT, CLOSE]))  # fmt: skip
    beside = SecondDetector("marks", Other(*(events for _, events in said)))

    logs = [(now_s, *log) for now_s, _ in said for log in beside.look(STATE, now_s)]

    blind = "also marks: it is dark"
    assert logs == [
        (0.0, "info", "also marks: close"),
        (2.6, "info", "also marks: close"),
        (2.7, "info", "also marks: in"),
        (2.8, "info", "also marks: close"),
        (2.9, "warning", blind),
        (2.9, "warning", blind),
    ]
    assert beside.speak(3.0) == ()


def test_it_is_asked_as_if_it_were_alone() -> None:
    seeing = Seeing([CLOSE])
    beside = SecondDetector("marks", seeing)
    assert (beside.due_s, beside.listening) == (3.5, False)
    assert SecondDetector("marks", Other(listening=True)).listening

    with entered([beside]):
        beside.restart(ROBOT)
        beside.react((), 1.0)
        logs = beside.look(STATE, 2.0)

    assert [log.message for log in logs] == ["I look", "also marks: close"]
    assert seeing.asked == [
        ("enter",),
        ("restart", ROBOT),
        ("react", (), 1.0),
        ("look", STATE, 2.0),
        ("speak", 2.0),
        ("exit",),
    ]
    SecondDetector("marks", Other()).restart(
        ROBOT
    )  # what does not count has nothing to begin again


def test_who_waits_for_a_key_cannot_stand_beside() -> None:
    with pytest.raises(UsageError, match="operator"):
        prepare(Order("mitre_bend", also="operator"))


def test_both_count_from_the_place_that_the_user_names() -> None:
    ready = prepare(
        Order("mitre_bend", detector="odometry", also="odometry", start_at_m=0.7125, seed=1)
    )
    assert [notice for notice in ready.notices if "712.5 mm" in notice] == [
        "detector: odometry, counted from the first wheel at 712.5 mm of the pipe",
        "also detector: odometry, counted from the first wheel at 712.5 mm of the pipe",
    ]


@pytest.mark.thorough
def test_the_log_of_a_run_from_python_shows_it() -> None:
    run = pirate_sm.run("mitre_bend", also="odometry", seed=1)

    assert run.outcome == "succeeded"
