"""The tests that every detector must pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import pytest

from pirate_sm.core import events as ev
from pirate_sm.core.companion import Companion, Counting, Onlooker, entered
from pirate_sm.core.effects import Effect
from pirate_sm.core.loading import LoadedMission
from pirate_sm.robot.detectors.registry import Asked, Detecting, MakeDetector
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, Prepared, prepare


@dataclass(frozen=True)
class Subject:
    """A detector's factory, and data to test it with.

    Attributes:
        make: The factory, as in the plugin of the entry point.
        mission: A mission; the detector is made for its robot and its pipe.
        backend: Backend that the mission runs on: ``sim`` or ``trace``.
        argument: The text after the colon in the detector's name; None without a colon.
        words: Whether the mission must receive at least one word.
    """

    make: MakeDetector
    mission: LoadedMission
    backend: str = "sim"
    argument: str | None = None
    words: bool = True


_MAY_BE_SAID = (ev.DetectorWord, ev.EnvironmentReport, ev.OutsideNumber, ev.FaultReport)


@dataclass
class _Heard:
    """Wraps a companion and checks what it reports, and when."""

    inner: Companion
    words: Sequence[str]
    said: list[ev.Event] = field(default_factory=list)

    @property
    def due_s(self) -> float:
        return self.inner.due_s

    @property
    def listening(self) -> bool:
        return self.inner.listening

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        self.inner.react(effects, now_s)

    def look(self, state: Any, now_s: float) -> Sequence[Any]:
        return self.inner.look(state, now_s) if isinstance(self.inner, Onlooker) else ()

    def speak(self, now_s: float) -> Sequence[ev.Event]:
        said = self.inner.speak(now_s)
        assert self.inner.due_s > now_s, "speak() must move due_s on, or time stands still"
        for event in said:
            assert isinstance(event, _MAY_BE_SAID)
            if isinstance(event, ev.DetectorWord):
                assert event.word in self.words, "the robot's profile has no such word"
                assert event.valid_for_s > 0.0
        self.said += said
        return said


class _NoTime:
    """A clock on which waiting takes no time, for companions that listen to a person."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now(self) -> float:
        return self._now_s

    def sleep(self, seconds: float) -> None:
        self._now_s += seconds


class DetectorContract:
    """Tests of a detector; a derived class gives the subject in a fixture."""

    @pytest.fixture
    def subject(self) -> Subject:
        """Return the subject to test."""
        raise NotImplementedError("a class derived from DetectorContract needs a fixture subject")

    def test_it_has_a_name(self, subject: Subject) -> None:
        """A detector has a name, and making it opens nothing."""
        _, found = made(subject)
        assert found.kind

    def test_a_mission_hears_words_that_the_robot_knows_at_times_that_go_on(
        self, subject: Subject
    ) -> None:
        """Its words exist in the robot's profile, and mission time never stands still."""
        said = heard(subject, *made(subject))

        assert said or not subject.words, "no word was said"

    def test_it_can_begin_again_for_another_mission(self, subject: Subject) -> None:
        """A detector that counts from the start of a mission can be restarted at any time."""
        ready, found = made(subject)
        for companion in found.companions:
            if isinstance(companion, Counting):
                companion.restart(subject.mission.robot)

        said = heard(subject, ready, found)

        assert said or not subject.words, "no word was said after a restart"


def made(subject: Subject) -> tuple[Prepared, Detecting]:
    """Return a run of the mission and its detector, made as a run makes it."""
    loaded = subject.mission
    ready = prepare(Order(loaded.documents[0].name, subject.backend), loaded)
    profile, robot = loaded.loaded_robot.profile, loaded.robot
    asked = Asked(
        profile,
        robot,
        loaded.pipe,
        places=ready.places,
        wheels=ready.wheels,
        argument=subject.argument,
    )
    return ready, subject.make(asked)


def heard(subject: Subject, ready: Prepared, found: Detecting) -> list[ev.Event]:
    """Return the events of the detector in the run."""
    words = subject.mission.robot.detector_words
    watched = [_Heard(companion, words) for companion in found.companions]
    with entered(found.companions):
        companions: list[Companion] = [*watched, FirstChoice()]
        run = MissionRun(ready.engine, ready.backend, companions=companions, clock=_NoTime())
        result = run.execute()
    if result.error is not None:
        raise result.error
    return [event for each in watched for event in each.said]
