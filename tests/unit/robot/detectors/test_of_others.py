"""What goes wrong in a detector of another package is said to be its own."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import inf
from typing import Any

import pytest

from pirate_sm.core.companion import Companion, Counting, Following, Onlooker, Relieved, entered
from pirate_sm.core.effects import Effect
from pirate_sm.core.errors import BackendError, DetectorError, UsageError
from pirate_sm.core.events import DetectorWord, Event
from pirate_sm.robot.detectors.registry import Detecting, OfOthers, _guards, guarded
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare

WHOSE = "the detector 'marks' (package pirate-marks: pirate_marks:DETECTOR)"
WORD = DetectorWord("close", 1.0)


class Silent:
    """A detector that says nothing."""

    due_s: Any = inf
    listening = False

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

    def speak(self, now_s: float) -> Any:
        self.due_s = now_s + 1.0
        return ()


class Raising(Silent):
    """A detector that raises in one method."""

    def __init__(self, method: str, error: BaseException | None = None) -> None:
        def broken(*given: Any) -> Any:
            raise error or AttributeError("no such thing")

        self.due_s = 0.0
        setattr(self, method, broken)


class Door(Silent):
    """A detector that is opened and closed."""

    def __init__(self, error: Exception | None = None) -> None:
        self.said: list[str] = []
        self._error = error

    def __enter__(self) -> None:
        if self._error is not None:
            raise self._error
        self.said.append("opened")

    def __exit__(self, *_: object) -> None:
        if "stuck" in self.said:
            raise OSError("stuck")
        self.said.append("closed")


class Saying(Silent):
    """A detector that returns this when it speaks, and stands still."""

    due_s = 0.0

    def __init__(self, said: Any) -> None:
        self._said = said

    def speak(self, now_s: float) -> Any:
        return self._said


def ran(companion: Companion) -> Any:
    ready = prepare(Order("mitre_bend", "trace"))
    return MissionRun(ready.engine, ready.backend, companions=[companion]).execute()


class Strange(Silent):
    """A detector nobody can ask whether it listens; it notes the effects."""

    @property
    def listening(self) -> bool:
        raise OSError("gone")

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        self.noted = effects, now_s


@pytest.mark.parametrize("method", ["react", "look", "speak"])
def test_a_run_ends_with_the_name_of_the_detector_that_has_raised(method: str) -> None:
    result = ran(OfOthers(WHOSE, Raising(method)))

    assert result.exit_code == DetectorError.exit_code == 3
    why = f"{WHOSE} fails in {method} with AttributeError: no such thing"
    assert result.ended.message == why
    assert isinstance(result.error, BackendError)


def test_a_run_ends_with_the_name_of_the_detector_that_lets_time_stand_still() -> None:
    result = ran(OfOthers(WHOSE, Saying(())))

    assert result.exit_code == 3
    assert result.ended.message == (
        f"{WHOSE} lets time stand still: due_s is 0 s at 0 s of mission time; speak must move it on"
    )


@pytest.mark.parametrize(
    ("said", "why"),
    [(None, "'NoneType' object is not iterable"), (("close",), "'close' is no event")],
)
def test_what_is_no_event_does_not_reach_the_engine(said: Any, why: str) -> None:
    with pytest.raises(DetectorError, match=why):
        OfOthers(WHOSE, Saying(said)).speak(0.0)


def test_whatever_a_detector_of_another_package_makes_fails_in_its_name() -> None:
    def broken() -> Any:
        raise AttributeError("no such thing")

    made = _guards(WHOSE, Detecting("marks", (Raising("speak"),), (), broken, broken))

    assert made.reckoned is not None
    assert made.camera is not None
    calls = {
        "speak": lambda: made.companions[0].speak(0.0),
        "reckoned": made.reckoned,
        "camera": made.camera,
    }
    for name, call in calls.items():
        with pytest.raises(DetectorError, match=re.escape(f"{WHOSE} fails in {name} with")):
            call()


def test_a_detector_may_speak_a_thousand_times_at_one_moment() -> None:
    other = OfOthers(WHOSE, Saying(()))
    for now_s in (0.0, 1.0, 1.00009):
        for _ in range(500):
            other.speak(now_s)
    with pytest.raises(DetectorError, match="lets time stand still"):
        other.speak(1.0001)
    other.speak(1.00011)


def test_a_detectors_own_error_keeps_its_words_and_another_of_ours_gets_its_name() -> None:
    with pytest.raises(DetectorError, match=r"^it is mine$"):
        OfOthers(WHOSE, Raising("react", DetectorError("it is mine"))).react((), 0.0)
    with pytest.raises(DetectorError, match="fails in react with UsageError: no such port"):
        OfOthers(WHOSE, Raising("react", UsageError("no such port"))).react((), 0.0)


def test_words_are_passed_on() -> None:
    other = OfOthers(WHOSE, Saying([WORD]))
    said: Sequence[Event] = other.speak(1.0)

    assert said == (WORD,)
    assert (other.due_s, other.listening) == (0.0, False)
    reacting = Silent()
    reacting.listening = True
    assert OfOthers(WHOSE, reacting).listening
    strange = Strange()
    OfOthers(WHOSE, strange).react((), 2.0)
    assert strange.noted == ((), 2.0)
    with pytest.raises(DetectorError, match=re.escape(f"{WHOSE} fails in listening with OSError")):
        _ = OfOthers(WHOSE, strange).listening


def test_a_time_that_is_none_is_said() -> None:
    silent = Silent()
    silent.due_s = None

    with pytest.raises(DetectorError, match="fails in due_s with TypeError"):
        _ = OfOthers(WHOSE, silent).due_s


@pytest.mark.parametrize(
    ("method", "kind"),
    [("look", Onlooker), ("restart", Counting), ("follow", Following)],
)
def test_it_can_do_what_the_detector_can(method: str, kind: type) -> None:
    assert isinstance(OfOthers(WHOSE, Raising(method)), kind)
    assert not isinstance(OfOthers(WHOSE, Silent()), (kind, Relieved))


def test_it_is_opened_and_closed_as_the_detector_is() -> None:
    door = Door()
    with entered([OfOthers(WHOSE, door), OfOthers(WHOSE, Silent())]):
        assert door.said == ["opened"]
    assert door.said == ["opened", "closed"]

    with (
        pytest.raises(DetectorError, match="fails in __exit__ with OSError: stuck"),
        entered([OfOthers(WHOSE, door)]),
    ):
        door.said.append("stuck")


def test_what_a_detector_refuses_as_it_is_opened_is_said_in_its_words() -> None:
    with (
        pytest.raises(UsageError, match=r"^no such port$"),
        entered([OfOthers(WHOSE, Door(UsageError("no such port")))]),
    ):
        pass
    with (
        pytest.raises(DetectorError, match="fails in __enter__ with OSError: gone"),
        entered([OfOthers(WHOSE, Door(OSError("gone")))]),
    ):
        pass


def test_a_function_of_a_detector_is_guarded_too() -> None:
    def where() -> float:
        raise ZeroDivisionError("division by zero")

    with pytest.raises(DetectorError, match="fails in reckoned with ZeroDivisionError"):
        guarded(WHOSE, "reckoned", where)()
