"""The detector ``vision`` with a perfect eye: what it makes of sightings, in closed loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import atan2, pi
from random import Random
from typing import NamedTuple

import pytest

from pirate_sm.detectors.camera_watch import CameraWatch
from pirate_sm.detectors.odometry_detector import Odometry
from pirate_sm.detectors.seen_places import OneMarker, Tags
from pirate_sm.detectors.vision_detector import Sight
from pirate_sm.geometry.plane import inner_corner
from pirate_sm.model.effects import Detected, Log
from pirate_sm.model.events import FaultReport, OutsideNumber
from pirate_sm.model.sighting import Mark, Sighting
from pirate_sm.runtime.first_choice import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.wiring import Order, Prepared, prepare

Places = Sequence[tuple[float, float]]


class Shown(NamedTuple):
    sighting: Sighting

    def jpeg(self) -> bytes:
        return b"a picture"


class TrueEye:
    """An eye that knows where the wheels are, ten times a second, and says it late."""

    def __init__(self, ready: Prepared, *, late_s: float = 0.1, noise_m: float = 0.0) -> None:
        assert ready.wheels is not None
        assert ready.loaded.pipe is not None
        self._wheels: Callable[[], Places] = ready.wheels
        self._origin = inner_corner(ready.loaded.pipe.route())
        self._late_s, self._noise_m, self._chance = late_s, noise_m, Random(1)
        self._taken: list[Sighting] = []
        self.due_s = 0.0
        self.fault = ""
        self.closed = False
        self.links: tuple[int, ...] = (0, 1, 2, 3, 4)
        self.headings = True
        self.change: Callable[[Sighting], Sighting | None] = lambda seen: seen

    def look(self, now_s: float) -> Sequence[Shown]:
        if now_s >= self.due_s:
            self.due_s = now_s + 0.1
            if (seen := self.change(self._sighting(now_s))) is not None:
                self._taken.append(seen)
        arrived = [each for each in self._taken if each.captured_s + self._late_s <= now_s]
        self._taken = self._taken[len(arrived) :]
        return [Shown(each) for each in arrived]

    def close(self) -> None:
        self.closed = True

    def _sighting(self, now_s: float) -> Sighting:
        marks = []
        for link, ((ax, ay), (bx, by)) in enumerate(pairwise(self._wheels())):
            x, y = (ax + bx) / 2 - self._origin[0], (ay + by) / 2 - self._origin[1]
            x, y = x + self._error(), y + self._error()
            heading = atan2(ay - by, ax - bx) if self.headings else None
            marks.append(Mark(str(link), (x, y), heading))
        seen = tuple(marks[link] for link in self.links)
        return Sighting(now_s, seen, 0.5, 100.0, self._chance.getrandbits(32))

    def _error(self) -> float:
        return self._chance.gauss(0.0, self._noise_m)


LINKS = {str(link): link for link in range(5)}


def setting(mission: str = "mitre_bend", seed: int = 1, **eye: float) -> tuple[Prepared, TrueEye]:
    ready = prepare(Order(mission, "sim", seed=seed, detector="odometry"))
    return ready, TrueEye(ready, **eye)


def tags(ready: Prepared, eye: TrueEye, **rest: object) -> Sight:
    loaded = ready.loaded
    assert loaded.pipe is not None
    route = loaded.pipe.route()
    placing = Tags(loaded.robot.body, route, LINKS)
    return Sight(loaded.loaded_robot.profile, loaded.robot, route, lambda: eye, placing, **rest)  # type: ignore[arg-type]


def marker(ready: Prepared, eye: TrueEye) -> Sight:
    loaded = ready.loaded
    assert loaded.pipe is not None
    profile, robot, route = loaded.loaded_robot.profile, loaded.robot, loaded.pipe.route()
    odometry = Odometry(profile, robot, loaded.pipe)
    eye.links, eye.headings = (2,), False
    return Sight(profile, robot, route, lambda: eye, OneMarker(route, 2), odometry=odometry)


def execute(ready: Prepared, sight: Sight) -> tuple[str, str, list[object]]:
    """Return outcome and message of the mission, and all its effects."""
    effects: list[object] = []

    class Watching(FirstChoice):
        def react(self, made: Sequence[object], now_s: float) -> None:
            effects.extend(made)
            super().react(made, now_s)  # type: ignore[arg-type]

    with sight:
        run = MissionRun(ready.engine, ready.backend, companions=[sight, Watching()])
        result = run.execute()
    assert result.error is None
    return result.ended.outcome, result.ended.message, effects


@pytest.mark.parametrize("make", [tags, marker])
def test_the_bend_is_passed_by_what_is_seen(make: Callable[..., Sight]) -> None:
    ready, eye = setting(noise_m=0.002)

    outcome, message, effects = execute(ready, make(ready, eye))

    assert outcome == "succeeded", message
    words = [each.word for each in effects if isinstance(each, Detected) and each.word]
    assert list(dict.fromkeys(words)) == ["close", "in", "past"]


def test_a_tag_that_is_hidden_for_a_moment_is_bridged_by_the_joints() -> None:
    ready, eye = setting()
    turn = 0

    def hide(seen: Sighting) -> Sighting:
        nonlocal turn
        turn += 1
        hidden = turn % 5
        marks = tuple(mark for mark in seen.marks if mark.on != str(hidden))
        return replace(seen, marks=marks)

    eye.change = hide
    outcome, message, _ = execute(ready, tags(ready, eye))

    assert outcome == "succeeded", message


def test_a_hidden_end_of_the_robot_becomes_unknown_and_no_word_is_said() -> None:
    ready, eye = setting()
    eye.links = (1, 2, 3, 4)
    sight = tags(ready, eye)

    outcome, _, effects = execute(ready, sight)

    assert outcome == "failed"
    assert not [each for each in effects if isinstance(each, Detected)]


def test_a_robot_that_leaps_is_not_believed() -> None:
    ready, eye = setting()

    def leap(seen: Sighting) -> Sighting:
        if not 8.0 <= seen.captured_s < 8.5:
            return seen
        moved = tuple(
            Mark(m.on, (m.place_m[0] + 0.3, m.place_m[1]), m.heading_rad) for m in seen.marks
        )
        return Sighting(seen.captured_s, moved, seen.rms_px, seen.gray_spread, seen.digest)

    eye.change = leap
    outcome, message, _ = execute(ready, tags(ready, eye))

    assert outcome == "succeeded", message


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda seen: None, "vision.silent"),
        (lambda seen: replace(seen, digest=7), "vision.frozen"),
        (lambda seen: replace(seen, marks=(), rms_px=None, gray_spread=3.0), "vision.dark"),
        (lambda seen: replace(seen, rms_px=4.6), "vision.moved"),
        (lambda seen: replace(seen, marks=()), "vision.blind"),
    ],
)
def test_what_goes_wrong_is_a_fault_and_no_word(
    change: Callable[[Sighting], Sighting | None], code: str
) -> None:
    ready, eye = setting()
    began_s = 6.0
    eye.change = lambda seen: change(seen) if seen.captured_s >= began_s else seen

    outcome, message, effects = execute(ready, tags(ready, eye))

    assert outcome == "fault"
    assert code in message
    words = [each for each in effects if isinstance(each, Detected) and each.word]
    assert not words, "no word is said of what is not seen"


def test_a_fault_is_reported_within_its_time_and_once_and_words_come_back() -> None:
    ready, eye = setting()
    state, _ = ready.engine.start()
    ready.backend.open()
    with tags(ready, eye) as sight:
        reports: list[tuple[float, str]] = []
        logs: list[Log] = []
        for turn in range(100):
            now_s = 0.05 * turn
            eye.change = lambda seen: None if 2.0 <= seen.captured_s < 3.0 else seen
            logs += sight.look(state, now_s)
            reports += [
                (now_s, event.code)
                for event in sight.speak(now_s)
                if isinstance(event, FaultReport)
            ]
    assert [code for _, code in reports] == ["vision.silent"]
    assert 2.0 < reports[0][0] <= 2.7
    assert [log.message for log in logs] == ["the camera sees the robot again"]


def test_a_robot_beside_the_pipe_is_nowhere_in_it() -> None:
    ready, eye = setting()
    eye.change = lambda seen: moved(seen, aside_m=-0.3)

    outcome, _, effects = execute(ready, tags(ready, eye))

    assert outcome == "failed"
    assert not [each for each in effects if isinstance(each, Detected) and each.word]


def test_a_robot_beside_the_pipe_is_warned_of_once() -> None:
    ready, eye = setting()
    state, _ = ready.engine.start()
    ready.backend.open()
    eye.change = lambda seen: moved(seen, aside_m=-0.3)
    with tags(ready, eye) as sight:
        logs = [log for turn in range(60) for log in sight.look(state, 0.05 * turn)]

    assert len(logs) == 1
    assert "the camera sees wheels outside of the pipe" in logs[0].message


@pytest.mark.parametrize("hidden", [None, 0, 4])
def test_the_speed_of_a_robot_that_faces_back_is_negative(hidden: int | None) -> None:
    ready, eye = setting()
    state, _ = ready.engine.start()
    ready.backend.open()
    eye.links = tuple(link for link in range(5) if link != hidden)
    eye.change = lambda seen: turned_round(moved(seen, along_m=0.1 * seen.captured_s))
    with tags(ready, eye, measures="camera") as sight:
        speeds = []
        for turn in range(40):
            sight.look(state, 0.05 * turn)
            events = sight.speak(0.05 * turn)
            speeds += [each.value for each in events if isinstance(each, OutsideNumber)]

    assert speeds == pytest.approx([-0.1] * len(speeds), abs=0.02)
    assert len(speeds) > 10


def moved(seen: Sighting, *, along_m: float = 0.0, aside_m: float = 0.0) -> Sighting:
    marks = (
        Mark(mark.on, (mark.place_m[0] + along_m, mark.place_m[1] + aside_m), mark.heading_rad)
        for mark in seen.marks
    )
    return replace(seen, marks=tuple(marks))


def turned_round(seen: Sighting) -> Sighting:
    """Return it as if the robot stood in the pipe the other way round."""
    marks = []
    for mark in seen.marks:
        assert mark.heading_rad is not None
        marks.append(Mark(str(4 - int(mark.on)), mark.place_m, mark.heading_rad + pi))
    return replace(seen, marks=tuple(marks))


@pytest.mark.parametrize(
    ("rms_px", "blind_after_s", "code"), [(9.0, 5.0, "vision.moved"), (0.5, 1.0, "vision.blind")]
)
def test_a_camera_that_has_never_shown_its_setup_or_the_robot_is_wrong_from_the_beginning_on(
    rms_px: float, blind_after_s: float, code: str
) -> None:
    watch, found = CameraWatch(blind_after_s), []
    for digest, now_s in enumerate((0.4, 0.8, 0.99, 1.0)):
        watch.take(Sighting(now_s, (), rms_px, 100.0, digest), now_s)
        found.append([fault.code for fault in watch.look(now_s, "", driven=True)])

    assert found == [[], [], [], [code]]


def test_a_camera_that_has_never_given_a_picture_is_silent_after_its_time() -> None:
    watch = CameraWatch(5.0)

    assert watch.look(0.49, "", driven=False) == []
    assert [fault.code for fault in watch.look(0.5, "", driven=False)] == ["vision.silent"]


@pytest.mark.parametrize(("make", "reckons"), [(tags, False), (marker, True)])
def test_whoever_counts_from_zero_again_lets_its_dead_reckoning_do_so_too(
    make: Callable[..., Sight], reckons: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ready, eye = setting()
    restarted: list[object] = []
    monkeypatch.setattr(Odometry, "restart", lambda _, robot: restarted.append(robot))

    make(ready, eye).restart(ready.loaded.robot)

    assert restarted == [ready.loaded.robot] * reckons
