"""The tests that every backend and every detector must pass."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import dist, inf
from random import Random
from typing import Any, get_args

import pytest

from pirate_sm.core import events as ev
from pirate_sm.core.companion import Companion, Counting, Onlooker, entered
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import Event, SubmitResult
from pirate_sm.core.loading import LoadedMission
from pirate_sm.robot.backends.protocol import Backend, Completion
from pirate_sm.robot.detectors.registry import Asked, Detecting, MakeDetector
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice, TriggerScript
from pirate_sm.running.wiring import Order, Prepared, prepare

# --- backends -----------------------------------------------------------------------------------


MOST_CALLS = 10_000

Values = tuple[float, ...]
Reported = list[tuple[float, Event]]


@dataclass(frozen=True)
class Candidate:
    """A backend's factory, and data to test it with.

    Attributes:
        make: Makes an unopened backend from a seed; equal seeds give equal backends.
        still: An array of setpoints that moves nothing.
        moving: Another array of setpoints, which moves the robot.
        mission: A mission that succeeds on the backend.
        places: Returns the position of the backend's robot, m; empty if unknown.
    """

    make: Callable[[int], Backend]
    still: Values
    moving: Values
    mission: LoadedMission
    places: Callable[[Any], Sequence[tuple[float, float]]] = lambda backend: ()


class BackendContract:
    """Tests of a backend; a derived class gives the candidate in a fixture."""

    @pytest.fixture
    def candidate(self) -> Candidate:
        """Return the candidate to test."""
        raise NotImplementedError("a class derived from BackendContract needs a fixture candidate")

    @pytest.fixture
    def backend(self, candidate: Candidate) -> Backend:
        """Return an unopened backend."""
        return candidate.make(0)

    def test_it_describes_itself(self, backend: Backend) -> None:
        """A backend has a name, a way of completion and a flag for real time."""
        assert backend.name
        assert backend.completion in get_args(Completion)
        assert backend.real_time in (True, False)

    def test_nothing_moves_before_the_first_array(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """Opening a backend and letting time pass moves no robot and gives no result."""
        backend.open()
        before = candidate.places(backend)
        reported = run_until(backend, 3.0)

        assert results(reported) == {}
        for place, now in zip(before, candidate.places(backend), strict=True):
            assert dist(place, now) < 1e-4

    def test_each_array_gets_exactly_one_result(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """Each array gets one result, however much time passes."""
        backend.open()
        reported: Reported = []
        for number in range(1, 6):
            backend.submit(number, candidate.moving)
            reported += run_until(backend, number * 2.0)

        assert results(reported) == dict.fromkeys(range(1, 6), 1)

    def test_arrays_in_quick_succession_get_one_result_each_and_the_last_is_not_superseded(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """Each array gets one result, and only an older one may be ``superseded``."""
        backend.open()
        for number in range(1, 4):
            backend.submit(number, candidate.moving if number % 2 else candidate.still)
        reported = run_until(backend, 3.0)

        statuses = dict(statuses_of(reported))
        assert results(reported) == {1: 1, 2: 1, 3: 1}
        assert statuses[3] != "superseded"

    def test_a_newer_array_is_accepted_after_one_that_it_may_supersede(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """Of two arrays at once, the first is sent before the second or never."""
        backend.open()
        backend.submit(1, candidate.moving)
        backend.submit(2, candidate.still)

        statuses = statuses_of(run_until(backend, 3.0))

        assert statuses in (
            [(1, "accepted"), (2, "accepted")],
            [(1, "superseded"), (2, "accepted")],
        )

    def test_no_array_of_a_stream_is_accepted_after_a_newer_one(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """Each array of a stream gets one result, and the newest is accepted in the end."""
        backend.open()
        reported: Reported = []
        for number in range(1, 41):
            backend.submit(number, candidate.moving if number % 2 else candidate.still)
            reported += run_until(backend, number * 0.016)
        reported += run_until(backend, 3.0)

        accepted = [number for number, status in statuses_of(reported) if status == "accepted"]
        assert results(reported) == dict.fromkeys(range(1, 41), 1)
        assert accepted == sorted(accepted)
        assert accepted[-1] == 40

    def test_the_same_array_may_be_submitted_again(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """An array that is submitted twice gets two results."""
        backend.open()
        backend.submit(1, candidate.moving)
        reported = run_until(backend, 2.0)
        backend.submit(1, candidate.moving)
        reported += run_until(backend, 4.0)

        assert results(reported) == {1: 2}

    def test_a_result_ends_an_advance_without_a_limit(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """A result does not wait for the end of an infinite ``advance``."""
        backend.open()
        backend.submit(1, candidate.moving)
        for _ in range(MOST_CALLS):
            now_s, events = backend.advance(inf)
            if any(isinstance(event, SubmitResult) for event in events):
                return
        raise AssertionError(f"no result by {now_s} s")

    @pytest.mark.parametrize("number", range(15))
    def test_time_neither_goes_back_nor_past_what_was_asked(
        self, candidate: Candidate, number: int
    ) -> None:
        """The time that ``advance`` returns lies between the last one and its limit."""
        chance, backend = Random(number), candidate.make(0)
        backend.open()
        now_s = until_s = 0.0
        for step in range(chance.randint(1, 12)):
            if chance.random() < 0.5:
                backend.submit(step + 1, candidate.moving)
            until_s += chance.choice([0.0, 1e-9, chance.uniform(0.0, 0.02), chance.random() / 2])
            reached_s, _ = backend.advance(until_s)
            assert now_s <= reached_s <= until_s
            now_s = reached_s

    def test_a_limit_in_the_past_changes_nothing(self, backend: Backend) -> None:
        """A limit in the past is no error, and nothing happens then."""
        backend.open()
        run_until(backend, 1.0)

        now_s, events = backend.advance(0.5)

        assert (now_s, list(events)) == (1.0, [])

    def test_equal_seeds_give_equal_events(self, candidate: Candidate) -> None:
        """Equal seeds give equal runs, to the bit."""
        reported = []
        for _ in range(2):
            backend = candidate.make(7)
            opened = list(backend.open())
            backend.submit(1, candidate.moving)
            first = run_until(backend, 2.0)
            backend.submit(2, candidate.still)
            reported.append((opened, first, run_until(backend, 4.0)))

        assert repr(reported[0]) == repr(reported[1])

    def test_it_may_be_closed_at_any_time_and_more_than_once(self, candidate: Candidate) -> None:
        """Closing never raises, also before opening and with an array on its way."""
        unopened = candidate.make(0)
        unopened.close()
        backend = candidate.make(0)
        backend.open()
        backend.submit(1, candidate.moving)
        backend.close()
        backend.close()

    def test_a_closed_backend_refuses_arrays_and_can_be_closed_again(
        self, candidate: Candidate, backend: Backend
    ) -> None:
        """An array for a closed backend is an error."""
        backend.open()
        backend.close()
        with pytest.raises(BackendError):
            backend.submit(1, candidate.still)
        backend.close()

    def test_a_mission_runs_on_it_to_its_end(self, candidate: Candidate) -> None:
        """A mission runs on the backend and succeeds."""
        backend, loaded = candidate.make(0), candidate.mission
        nominal = backend.completion == "nominal"
        engine = Engine(loaded.robot, loaded.program, nominal=nominal)

        companions = (TriggerScript(loaded.program), FirstChoice())
        result = MissionRun(engine, backend, companions=companions).execute()

        assert (result.ended.outcome, result.exit_code) == ("succeeded", 0), result.ended.message


def run_until(backend: Backend, until_s: float) -> Reported:
    """Return all events up to this time, with their times."""
    reported: Reported = []
    for _ in range(MOST_CALLS):
        now_s, events = backend.advance(until_s)
        assert now_s <= until_s
        reported += [(now_s, event) for event in events]
        if now_s >= until_s and not events:
            return reported
    raise AssertionError(f"{until_s} s are never reached")


def results(reported: Sequence[tuple[float, Event]]) -> Counter[int]:
    """Return how many results each array got."""
    return Counter(number for number, _ in statuses_of(reported))


def statuses_of(reported: Sequence[tuple[float, Event]]) -> list[tuple[int, str]]:
    """Return the id and status of each result, in order."""
    return [
        (each.setpoint_id, each.status) for _, each in reported if isinstance(each, SubmitResult)
    ]


# --- detectors ----------------------------------------------------------------------------------


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
