"""The detector ``vision`` with a perfect eye: what it makes of sightings, in closed loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import atan2, inf, nan, pi
from random import Random
from typing import Any, Literal, NamedTuple

import pytest

from pirate_sm.core.effects import Detected, Ended, Log
from pirate_sm.core.engine import Engine
from pirate_sm.core.events import (
    DetectorWord,
    FaultReport,
    OutsideNumber,
    SeenMark,
    Sighting,
    Truth,
)
from pirate_sm.core.geometry import DRAWING, ChainInSpace, inner_corner, walls
from pirate_sm.robot.detectors.dead_reckoning import Reckoned
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.vision_detector import CameraSight, OneMarker, SeenWheels, Tags
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, Prepared, load, prepare

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
            marks.append(SeenMark(str(link), (x, y), heading))
        seen = tuple(marks[link] for link in self.links)
        return Sighting(now_s, seen, 0.5, 100.0, self._chance.getrandbits(32))

    def _error(self) -> float:
        return self._chance.gauss(0.0, self._noise_m)


LINKS = {str(link): link for link in range(5)}


def setting(mission: str = "mitre_bend", seed: int = 1, **eye: float) -> tuple[Prepared, TrueEye]:
    ready = prepare(Order(mission, "sim", seed=seed, detector="odometry"))
    return ready, TrueEye(ready, **eye)


def tags(ready: Prepared, eye: TrueEye, **rest: object) -> CameraSight:
    loaded = ready.loaded
    assert loaded.pipe is not None
    route = loaded.pipe.route()
    placing = Tags(loaded.robot.body, route, LINKS)
    return CameraSight(
        loaded.loaded_robot.profile, loaded.robot, route, lambda: eye, placing, **rest
    )  # type: ignore[arg-type]


def marker(ready: Prepared, eye: TrueEye) -> CameraSight:
    loaded = ready.loaded
    assert loaded.pipe is not None
    profile, robot, route = loaded.loaded_robot.profile, loaded.robot, loaded.pipe.route()
    odometry = Odometry(profile, robot, loaded.pipe)
    eye.links, eye.headings = (2,), False
    return CameraSight(profile, robot, route, lambda: eye, OneMarker(route, 2), odometry=odometry)


def execute(ready: Prepared, sight: CameraSight) -> tuple[str, str, list[object]]:
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


@pytest.mark.parametrize("make", [tags, pytest.param(marker, marks=pytest.mark.thorough)])
def test_the_bend_is_passed_by_what_is_seen(make: Callable[..., CameraSight]) -> None:
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
            SeenMark(m.on, (m.place_m[0] + 0.3, m.place_m[1]), m.heading_rad) for m in seen.marks
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
        SeenMark(mark.on, (mark.place_m[0] + along_m, mark.place_m[1] + aside_m), mark.heading_rad)
        for mark in seen.marks
    )
    return replace(seen, marks=tuple(marks))


def turned_round(seen: Sighting) -> Sighting:
    """Return it as if the robot stood in the pipe the other way round."""
    marks = []
    for mark in seen.marks:
        assert mark.heading_rad is not None
        marks.append(SeenMark(str(4 - int(mark.on)), mark.place_m, mark.heading_rad + pi))
    return replace(seen, marks=tuple(marks))


class Script:
    """A camera, dead reckoning and a way to find the wheels that all do as a test says."""

    def __init__(self, **options: Any) -> None:
        self.loaded = load(Order("mitre_bend"))
        profile, route = self.loaded.loaded_robot.profile, self.loaded.pipe.route()
        self.state, _ = Engine(self.loaded.robot, self.loaded.program, nominal=True).start()
        self.due_s, self.fault, self.closed = 0.0, "", False
        self.reckoned: Any = None
        self._coming: list[Shown] = []
        self._places: dict[int, Sequence[float]] = {}
        placing = options.pop("placing", self)
        if options.pop("reckons", False):
            options["odometry"] = self
        self.sight = CameraSight(
            profile, self.loaded.robot, route, lambda: self, placing, **options
        )
        self.sight.__enter__()

    def look(self, *given: Any) -> Any:
        """Be the camera that is asked for its pictures, or the odometry that is given a state."""
        if len(given) == 2:
            return ()
        coming, self._coming = self._coming, []
        return coming

    def close(self) -> None:
        self.closed = True

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        places_m = self._places[sighting.digest]
        assert len(angles) == 6
        inside = tuple(nan if place == OUTSIDE_M else place for place in places_m)
        return SeenWheels(inside, tuple((place, 0.5) for place in places_m))

    def drives(self, way: int, polarity: Literal["normal", "mirrored"] = "normal") -> None:
        robot = self.loaded.loaded_robot.oriented(polarity)
        values = list(self.state.robot.values)
        for wheel in robot.wheels:
            values[wheel.slot] = way * (1.0 if wheel.metres_per_rad > 0 else -1.0)
        self.state = self.state._replace(robot=self.state.robot._replace(values=tuple(values)))

    def shows(
        self, captured_s: float, *places_m: float, now_s: float | None = None, **seen: Any
    ) -> list[str]:
        """Show the wheels at these places, or all at one; return what is said to people."""
        digest = len(self._places)
        self._places[digest] = places_m if len(places_m) == 6 else places_m * 6
        mark = SeenMark("head", (0.0, 0.0), 0.0)
        sighting = replace(Sighting(captured_s, (mark,), 0.5, 100.0, digest), **seen)
        self._coming.append(Shown(sighting))
        logs = self.sight.look(self.state, captured_s if now_s is None else now_s)
        return [log.message for log in logs]


OUTSIDE_M = 1000.0
"""A place that is shown as one outside of the pipe."""


@pytest.mark.parametrize(
    ("moved_m", "passed_s", "believed"),
    [
        (0.049, 0.1, True),
        (0.051, 0.1, False),
        (-0.051, 0.1, False),
        (0.5, 1.0, False),
        (0.5, 1.01, True),
        (0.319, 1.0, True),
        (nan, 0.1, False),
    ],
)
def test_belief_in_a_place_to_which_the_robot_cannot_have_moved_begins_after_its_time(
    moved_m: float, passed_s: float, believed: bool
) -> None:
    script = Script()
    assert script.sight.seen is None
    script.shows(1.0, 5.0)
    script.shows(1.0 + passed_s, 5.0 + moved_m)

    assert script.sight.seen.places_m[0] == pytest.approx(5.0 + moved_m if believed else 5.0)
    # What is not believed is not what the next sighting is held against.
    script.shows(1.0 + passed_s + 0.01, 5.0 + (moved_m if believed else 0.0))
    assert script.sight.seen.places_m[0] == pytest.approx(5.0 + moved_m if believed else 5.0)


def test_one_wheel_that_leaps_is_enough_for_doubt() -> None:
    script = Script()
    script.shows(1.0, 0.5)
    script.shows(1.1, 0.5, 0.5, 0.5, 0.5, 0.5, 0.9)

    assert script.sight.seen.places_m == (0.5,) * 6


def test_wheels_outside_of_the_pipe_are_warned_of_once_each_time() -> None:
    script, said = Script(), []
    for number, outside in enumerate("1110111111111110111111"):
        place_m = OUTSIDE_M if outside == "1" else 0.5
        if script.shows(2.0 + 0.25 * number, place_m, 0.5, 0.5, 0.5, 0.5, 0.5):
            said.append(number)

    assert said == [7, 19]


def test_the_second_opinion_is_heard_when_it_begins_to_differ() -> None:
    script, said = Script(reckons=True), []
    assert script.shows(1.0, 0.5) == []  # it has not reckoned yet
    script.reckoned = Reckoned((nan,) * 6, ChainInSpace((), DRAWING, DRAWING), 0.0, 0, {}, 0.0)
    assert script.shows(1.5, 0.5) == []  # it is lost
    for number, off_m in enumerate((0.04, 0.05, 0.051, 0.06, 0.03, 0.055, 0.02, 0.04, -0.052)):
        chain = ChainInSpace((), DRAWING, DRAWING)
        script.reckoned = Reckoned((nan, 0.0, *(off_m,) * 4), chain, 0.0, 0, {}, 0.0)
        for message in script.shows(10.0 + 2 * number, 7.0, *(0.0,) * 5):
            said.append((off_m, message))

    assert said == [
        (off_m, f"the camera and dead reckoning differ by {text} mm; the camera counts")
        for off_m, text in ((0.051, "51"), (-0.052, "52"))
    ]


def test_the_second_opinion_is_heard_where_it_differs_from_the_beginning_on() -> None:
    script = Script(reckons=True)
    chain = ChainInSpace((), DRAWING, DRAWING)
    script.reckoned = Reckoned((0.6,) * 6, chain, 0.0, 0, {}, 0.0)

    assert script.shows(1.0, 0.5)[0].startswith("the camera and dead reckoning differ by 100 mm")


def test_one_marker_has_no_opinion_of_its_own() -> None:
    placing = OneMarker(load(Order("mitre_bend")).pipe.route(), 2)
    script = Script(reckons=True, placing=placing)
    chain = ChainInSpace(tuple((0.1 * x, 0.0, 0.0) for x in range(5, -1, -1)), DRAWING, DRAWING)
    script.reckoned = Reckoned((0.1,) * 6, chain, 0.0, 0, {}, 0.0)

    assert script.shows(1.0, 0.5) == []
    assert placing.reckoned is script.reckoned
    assert script.sight.seen.places_m[2] > 0.9


@pytest.mark.parametrize(
    ("measures", "wheels", "said"),
    [
        ("ruler", [0.0] * 6, [(0.1, 0.05)]),
        ("ruler", [nan, nan, 0.2, 0.1, nan, nan], [(0.1, 0.05)]),
        ("ruler", [nan, nan, 0.1, 0.2, nan, nan], [(-0.1, 0.05)]),
        ("ruler", [0.2, 0.21, 0.1, 0.0, nan, nan], [(0.1, 0.05)]),  # the first two are uncertain
        ("ruler", [nan, nan, 0.1, nan, nan, nan], []),
        ("", [0.0] * 6, []),
    ],
)
def test_the_speed_of_the_wheels_is_measured_from_two_sightings(measures, wheels, said) -> None:
    script = Script(measures=measures)
    script.drives(1)
    for step in range(3):  # the first one is of a moment before the wheels were driven
        at_s = 1.0 + 0.1 * step
        places = [0.5 + 0.01 * step + off_m - 0.001 * n for n, off_m in enumerate(wheels)]
        script.shows(at_s, *places, now_s=at_s + 0.05)
        events = script.sight.speak(at_s + 0.05)

    found = [(each.value, each.age_s) for each in events if isinstance(each, OutsideNumber)]
    assert found == [pytest.approx(each) for each in said]


def test_what_is_seen_is_shown_with_a_picture_twice_a_second() -> None:
    script, pictures = Script(), []
    assert script.sight.view() is None
    for step in range(9):
        script.shows(1.0 + 0.125 * step, 0.5)
        view = script.sight.view()
        assert view.seen is script.sight.seen
        assert view.sighting.captured_s == 1.0 + 0.125 * step
        pictures.append(view.jpeg)

    assert pictures == [b"a picture", b"", b"", b""] * 2 + [b"a picture"]


def test_nothing_is_shown_of_a_camera_that_has_not_seen_the_robot() -> None:
    script = Script()
    script.shows(1.0, nan)
    assert script.sight.newest is not None
    assert script.sight.view() is None
    assert script.sight.truth() is None


def test_the_place_is_shown_where_all_wheels_are_seen() -> None:
    script = Script()
    script.shows(1.0, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)
    truth, profile = script.sight.truth(), script.loaded.loaded_robot.profile
    assert truth == Truth(
        script.sight.seen.points, profile.body.wheel_radius, walls(script.loaded.pipe.route()), 0.6
    )
    script.shows(1.1, 0.6, 0.5, nan, 0.3, 0.2, 0.1)
    assert script.sight.truth() is None


@pytest.mark.parametrize(
    ("camera_due_s", "due_s"), [(2.02, 2.02), (2.2, 2.05), (2.0, 2.05), (1.0, 2.05)]
)
def test_it_looks_when_the_camera_asks_for_it_or_every_50_ms(
    camera_due_s: float, due_s: float
) -> None:
    script = Script()
    assert script.sight.due_s == 0.0
    script.due_s = camera_due_s
    assert script.sight.speak(2.0) == ()
    assert script.sight.due_s == pytest.approx(due_s)


def test_it_listens_to_a_camera_in_real_time_until_the_run_ends_and_closes_it() -> None:
    assert not Script().sight.listening
    script = Script(live=True)
    script.sight.react((Log("info", "x"),), 1.0)
    assert script.sight.listening
    script.sight.react((Log("info", "x"), Ended("succeeded", "done")), 1.0)
    assert (script.sight.listening, script.sight.due_s) == (False, inf)
    script.sight.__exit__()
    assert script.closed


@pytest.mark.parametrize(("way", "codes"), [(0, []), (1, ["vision.blind"]), (-1, ["vision.blind"])])
def test_a_robot_that_is_driven_has_to_be_in_sight(way: int, codes: list[str]) -> None:
    script, found = Script(), []
    script.drives(way)
    for step in range(30):
        script.shows(0.05 * step, nan, marks=())
        found += [event.code for event in script.sight.speak(0.05 * step)]

    assert found == codes


def test_no_word_is_said_of_what_a_camera_sees_that_cannot_be_believed() -> None:
    script = Script()
    script.drives(1)
    said = words_on_the_way(script, gray_spread=3.0)

    assert [word for word, _ in said] == []


def words_on_the_way(script: Script, **seen: Any) -> list[tuple[str, bool]]:
    """Drive through the bend; return each word once, and whether a picture is kept with it."""
    found: list[tuple[str, bool]] = []
    for step in range(160):
        at_s, first_m = 1.0 + 0.05 * step, 0.7 + 0.005 * step
        script.shows(at_s, *(first_m - 0.06 * wheel for wheel in range(6)), **seen)
        view = script.sight.view()
        for word in script.sight.speak(at_s):
            if isinstance(word, DetectorWord) and word.word not in dict(found):
                found.append((word.word, bool(view.jpeg)))
    return found


def test_each_word_is_kept_with_its_picture() -> None:
    script = Script()
    script.drives(1)

    assert words_on_the_way(script) == [("close", True), ("in", True), ("past", True)]


def test_the_next_mission_may_have_another_polarity() -> None:
    script = Script()
    script.sight.restart(script.loaded.loaded_robot.mirrored)
    script.drives(1, "mirrored")

    assert [word for word, _ in words_on_the_way(script)] == ["close", "in", "past"]


@pytest.mark.parametrize(("make", "reckons"), [(tags, False), (marker, True)])
def test_whoever_counts_from_zero_again_lets_its_dead_reckoning_do_so_too(
    make: Callable[..., CameraSight], reckons: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ready, eye = setting()
    restarted: list[object] = []
    monkeypatch.setattr(Odometry, "restart", lambda _, robot: restarted.append(robot))

    make(ready, eye).restart(ready.loaded.robot)

    assert restarted == [ready.loaded.robot] * reckons
