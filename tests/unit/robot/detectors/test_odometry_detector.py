from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import nan, radians
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from representative import thorough_but

from pirate_sm.core._engine.robot.robot_state import LAPSED
from pirate_sm.core.companion import Onlooker
from pirate_sm.core.effects import CommandStatus, Effect, Log, Setpoints, StateChange
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import DetectorWord, Event, FaultReport
from pirate_sm.core.geometry import DRAWING, ChainInSpace
from pirate_sm.core.models import Pipe
from pirate_sm.core.robot import Mark, RobotSpec, confirmed_parts
from pirate_sm.robot.detectors.dead_reckoning import AnchorSpot, Felt, Reckoned, Shape
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, load, prepare
from pirate_sm.running.wiring.prepared import Prepared

ROBOTS = Path(__file__).resolve().parents[3] / "robots"
PATROL = str(ROBOTS / "newt" / "patrol.yaml")


def reckoning(prepared: Prepared) -> Odometry:
    """The detector among what accompanies the run."""
    return next(each for each in prepared.companions if isinstance(each, Odometry))


def run(mission: str, **order) -> tuple:
    prepared = prepare(Order(mission, **order))
    odometry = reckoning(prepared)
    companions = [*prepared.companions, FirstChoice()]
    result = MissionRun(prepared.engine, prepared.backend, companions=companions).execute()
    assert odometry.reckoned is not None
    return result, odometry.reckoned.places_m, prepared.backend.truth.arcs_m


def in_a_round_m() -> float:
    """Return how far the robot drives while each board reports once, at the most.

    By then some joints are as they are now and others as they were: the chain of wheels is moved to
    where the walls have room for such a shape.
    """
    robot = prepare(Order("mitre_bend", backend="trace")).loaded.robot
    return robot.link.period_s * max(wheel.top_m_s for wheel in robot.wheels)


@pytest.mark.parametrize(
    "mission", thorough_but(["mitre_bend_backward"], ["mitre_bend", "mitre_bend_backward"])
)
def test_the_bend_is_passed_on_reckoning_alone(mission: str) -> None:
    result, places, truth = run(mission, detector="odometry")
    assert result.ended.outcome == "succeeded"
    assert places == pytest.approx(truth, abs=in_a_round_m())


@pytest.mark.parametrize("mission", [
    "two_bends_up",
    "house_connection_back",
    pytest.param("two_bends_down", marks=pytest.mark.slow),
    pytest.param("house_and_back", marks=pytest.mark.slow),
])  # fmt: skip
@pytest.mark.thorough
def test_networks_are_passed_on_reckoning_alone(mission: str) -> None:
    result, places, truth = run(mission, detector="odometry", seed=1)
    assert result.ended.outcome == "succeeded"
    assert places == pytest.approx(truth, abs=0.015)


def test_a_robot_in_a_round_pipe_is_shown_in_space() -> None:
    prepared = prepare(Order("turn_left", detector="odometry"))
    odometry = reckoning(prepared)
    companions = [*prepared.companions, FirstChoice()]
    MissionRun(prepared.engine, prepared.backend, companions=companions).execute()
    shown, truth = odometry.truth(), prepared.backend.truth
    for one, other in zip(shown.points, truth.points, strict=True):
        assert one == pytest.approx(other, abs=0.02)
    assert shown.rolls_rad == pytest.approx(truth.rolls_rad, abs=radians(10))


@pytest.mark.parametrize("off_m", thorough_but([-0.03], [0.03, -0.03]))
def test_an_error_of_the_start_is_gone_behind_the_bend(off_m: float) -> None:
    _, places, truth = run("mitre_bend", detector="odometry", start_at_m=0.7 + off_m)
    assert abs(off_m) > 1.5 * in_a_round_m()
    assert places == pytest.approx(truth, abs=in_a_round_m())


def test_belief_the_shape_is_unknown_while_a_part_is_not_seen_to_hold() -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    mission = MissionRun(prepared.engine, prepared.backend, companions=prepared.companions)
    mission.execute()
    assert companion.reckoned.shape == "fits"

    body = mission.state.robot
    lapsed = body._replace(marks=body.marks | {Mark("part", 0, LAPSED)})
    companion.look(mission.state._replace(robot=lapsed), 100.0)

    assert companion.reckoned.shape == "unknown"


def test_the_simulators_own_words_are_not_said() -> None:
    # Reckoned from here the bend is never reached, in truth it is.
    result, _, _ = run("mitre_bend", detector="odometry", start_at_m=0.1)
    assert (result.ended.outcome, result.ended.end) != ("succeeded", "passed")


def test_any_robot_can_reckon() -> None:
    _, places, truth = run(PATROL, detector="odometry")
    assert places == pytest.approx(truth, abs=0.06)


def odometry(**options) -> Odometry:
    loaded = prepare(Order("mitre_bend", backend="trace")).loaded
    assert loaded.pipe is not None
    return Odometry(loaded.loaded_robot.profile, loaded.robot, loaded.pipe, **options)


PAST = frozenset({"past"})
NOWHERE = ChainInSpace((), DRAWING, DRAWING)


@pytest.mark.parametrize(
    ("course", "doubted"),
    [
        ([("contradicts", 0.0), ("contradicts", 0.11), ("contradicts", 0.12)], [2]),
        ([("contradicts", 1.0), ("contradicts", 0.85)], [1]),
        ([("contradicts", 0.0), ("contradicts", 0.2), ("contradicts", 0.5)], [1]),
        ([("contradicts", 0.0), ("fits", 0.1), ("contradicts", 0.13)], []),
        ([("contradicts", 0.0), ("unknown", 0.1), ("contradicts", 0.13)], []),
        ([("contradicts", 0.0), ("fits", 0.1), ("contradicts", 0.2), ("contradicts", 0.33)], [3]),
        ([("unknown", 0.0), ("unknown", 0.2)], []),
    ],
)
def test_belief_in_a_passed_bend_ends_when_the_shape_contradicts_it_for_long(
    course: list[tuple[Shape, float]], doubted: list[int]
) -> None:
    companion = odometry()
    companion._detector._number = 0
    assert companion._detector.due == "past"
    looks = [Reckoned((), NOWHERE, odometer_m, 0, {}, 0.0, shape) for shape, odometer_m in course]

    faults = [companion._doubt(PAST, each, []) for each in looks]

    assert [number for number, fault in enumerate(faults) if fault is not None] == doubted
    for number in doubted:
        fault = faults[number]
        assert fault is not None
        assert fault.code == "place.contradicted"
        assert "odometry is where it would say 'past', but the robot does not fit" in (
            fault.message
        )
    assert not any(companion._doubt(frozenset(), each, []) for each in looks)


@pytest.mark.parametrize(
    ("course", "clear"),
    [
        ([(True, 0.0), (True, 1.0)], [True, True]),
        ([(False, 0.3), (True, 0.31), (True, 0.359), (True, 0.361)], [False, False, False, True]),
        ([(False, 0.3), (True, 0.25), (True, 0.239)], [False, False, True]),
        ([(False, 0.3), (None, 0.4), (False, 0.4), (True, 0.41)], [False, True, False, False]),
    ],
)
def test_belief_that_a_bend_is_passed_needs_a_way_that_was_rolled_straight(
    course: list[tuple[bool | None, float]], clear: list[bool]
) -> None:
    """Wheels slip round the bend: odometry may be ahead when the robot has just come straight."""
    companion, found = odometry(), []
    both = {0: AnchorSpot(2.0, 0.0), 1: AnchorSpot(1.8, 0.0)}
    for straight, odometer_m in course:  # None: one part alone holds, and the other may be anywhere
        spots = both if straight is not None else {0: both[0]}
        at = (), NOWHERE, odometer_m, 0, spots, 0.0
        companion.reckoned = Reckoned(*at, "fits", straight=bool(straight))
        found.append(companion._clear())

    assert found == clear


@pytest.mark.parametrize("place", [-0.001, 2.001])
def test_a_place_outside_the_pipe_is_refused(place: float) -> None:
    with pytest.raises(UsageError, match="outside the pipe, which is 2000 mm long"):
        odometry(first_wheel_m=place)


def test_it_counts_from_the_pipes_own_place_and_looks_every_50_ms() -> None:
    companion = odometry()
    assert isinstance(companion, Onlooker)
    assert companion.first_wheel_m == pytest.approx(0.7)
    assert companion.due_s == 0.0
    assert companion.speak(0.0) == ()
    assert companion.due_s == pytest.approx(0.05)


def test_it_waits_for_every_joint_and_says_once_that_it_does() -> None:
    prepared = prepare(Order("mitre_bend", backend="trace"))
    companion = odometry()
    state, _ = prepared.engine.start()
    assert companion.look(state, 0.5) == ()
    (warning,) = companion.look(state, 1.0)
    joints = "gamma_1, gamma_2, gamma_3, gamma_4 unknown"
    assert joints in warning.message
    assert companion.look(state, 1.1) == ()
    assert companion.reckoned is None
    assert companion.speak(1.1) == ()


def test_a_word_is_said_once_it_holds_and_again_while_it_does() -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    said: list[tuple[float, DetectorWord]] = []
    speak = companion.speak

    def note(now_s: float):
        words = speak(now_s)
        said.extend((now_s, word) for word in words if isinstance(word, DetectorWord))
        return words

    companion.speak = note
    MissionRun(prepared.engine, prepared.backend, companions=prepared.companions).execute()
    assert list(dict.fromkeys(word.word for _, word in said)) == ["close", "in", "past"]
    gaps = [late - early for (early, a), (late, b) in pairwise(said) if a == b]
    # Half of the time for which it is valid, and until the next of the looks near a bend.
    assert 0.5 - 1e-9 < min(gaps) < 0.5 + LOOK_EVERY_S
    assert {word.valid_for_s for _, word in said} == {1.0}


def test_a_place_that_is_lost_is_told_once_and_no_word_is_said_any_more() -> None:
    prepared = prepare(Order("mitre_bend", backend="trace"))
    companion = odometry()
    assert companion.truth() is None, "it is not known before the first look either"
    state, _ = prepared.engine.start()
    nowhere = ChainInSpace(((nan, nan, nan),) * 6, DRAWING, DRAWING)
    companion.reckoned = Reckoned((nan,) * 6, nowhere, 0.0, 0, {}, 0.0)
    (warning,) = companion.look(state, 20.0)
    assert warning.message.startswith("odometry has lost the robot's place while the hold changed")
    assert "gamma_2" in warning.message
    assert companion.look(state, 20.1) == ()
    assert companion.speak(20.1) == ()
    assert companion.truth() is None


@pytest.mark.parametrize(("silent_s", "outcome"), [(0.5, "succeeded"), (2.0, "failed")])
def test_a_joint_may_be_silent_for_a_moment_while_the_hold_changes(
    silent_s: float, outcome: str
) -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    robot, look = prepared.loaded.robot, companion.look
    joint = robot.vocabulary.numbers.index("gamma_4")
    held_s: list[float] = []

    def look_with_a_silent_joint(state, now_s: float):
        """The joint is silent from when the front begins to clamp until after it holds."""
        numbers = list(state.sensing.numbers)
        if not held_s and confirmed_parts(robot, state.robot):
            held_s.append(now_s)
        clamping = any(mark.kind == "part" for mark in state.robot.marks) and not held_s
        if clamping or (held_s and now_s < held_s[0] + silent_s):
            numbers[joint] = nan
        sensing = state.sensing._replace(numbers=tuple(numbers))
        return look(state._replace(sensing=sensing), now_s)

    companion.look = look_with_a_silent_joint
    companions = [*prepared.companions, FirstChoice()]
    result = MissionRun(prepared.engine, prepared.backend, companions=companions).execute()
    assert held_s
    assert result.ended.outcome == outcome


def test_a_robot_in_a_plane_is_shown_within_its_walls() -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    companions = [*prepared.companions, FirstChoice()]
    MissionRun(prepared.engine, prepared.backend, companions=companions).execute()

    shown, truth = companion.truth(), prepared.backend.truth
    assert (shown.walls, shown.wheel_radius_m) == (truth.walls, truth.wheel_radius_m)
    assert shown.distance_m > 0.5
    for one, other in zip(shown.wheels, truth.wheels, strict=True):
        assert one == pytest.approx(other, abs=0.02)


def test_a_robot_that_counts_from_zero_again_stays_where_it_is() -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    run = MissionRun(
        prepared.engine, prepared.backend, companions=[*prepared.companions, FirstChoice()]
    )
    end_s = run.execute().now_s
    places_m = companion.reckoned.places_m

    companion.restart(prepared.loaded.robot)
    companion.look(run.state, end_s + 1.0)

    assert companion.reckoned.places_m == pytest.approx(places_m, abs=0.001)


@pytest.mark.parametrize(("straight_for_m", "said"), [(0.07, True), (0.02, False)])
def test_a_robot_that_counts_from_zero_again_has_to_roll_on_only_for_the_rest(
    straight_for_m: float, said: bool
) -> None:
    prepared = prepare(Order("mitre_bend", detector="odometry"))
    companion = reckoning(prepared)
    run = MissionRun(
        prepared.engine, prepared.backend, companions=[*prepared.companions, FirstChoice()]
    )
    end_s = run.execute().now_s
    companion._bent_m = companion.reckoned.odometer_m - straight_for_m

    companion.restart(prepared.loaded.robot)
    companion.look(run.state, end_s + 1.0)

    assert companion._clear() == said


class Reckoning:
    """Dead reckoning and an odometer that show what a test wants, and note what they are asked."""

    def __init__(self, robot: RobotSpec | None = None, pipe: Pipe | None = None) -> None:
        loaded = load(Order("mitre_bend"))
        self.robot, self.pipe = robot or loaded.robot, pipe or loaded.pipe
        self.state, _ = Engine(loaded.robot, loaded.program, nominal=True).start()
        values = list(self.state.robot.values)
        for wheel in self.robot.wheels:
            values[wheel.slot] = 1.0 if wheel.metres_per_rad > 0 else -1.0
        self.state = self.state._replace(robot=self.state.robot._replace(values=tuple(values)))
        self.companion = Odometry(loaded.loaded_robot.profile, self.robot, self.pipe)
        self.companion._reckoner = self.companion._odometer = self  # type: ignore[assignment]
        self.shape: Shape = "fits"
        self.is_straight = True
        self.way_m, self.front_m = 0.0, 0.5
        self.hidden = -1
        self.spots: Mapping[int, AnchorSpot] = {0: AnchorSpot(0.5, 0.1), 1: AnchorSpot(0.4, 0.2)}
        self.silent: list[int] = []
        self.lying: Sequence[int] = (0, 1)
        self.asked: list[tuple[Any, ...]] = []

    def unknown(self, numbers: Sequence[float]) -> list[int]:
        return self.silent

    def begin(self, *given: Any) -> Reckoned:
        self.asked.append(("begin", *given))
        return self.reckoned

    def look(self, *given: Any) -> Any:
        if isinstance(given[0], Reckoned):
            self.asked.append(("look", *given))
            return self.reckoned
        self.asked.append(("odometer", *given))
        return self.way_m

    def lies(self, numbers: Sequence[float], part: int, middle_m: float) -> bool:
        return part in self.lying

    def roll_of(self, reckoned: Reckoned, part: int) -> float:
        return 0.3 + 0.1 * part

    @property
    def reckoned(self) -> Reckoned:
        places_m = tuple(
            nan if wheel == self.hidden else self.front_m - 0.05 * wheel for wheel in range(6)
        )
        points = tuple((place, 0.01, 0.02) for place in places_m)
        chain = ChainInSpace(points, DRAWING, DRAWING)
        at = places_m, chain, self.way_m, 1, dict(self.spots), 0.0
        return Reckoned(*at, self.shape, self.is_straight)

    def shows(self, now_s: float, **signals: float) -> list[Event]:
        """Look with these signals, and return what is said."""
        numbers = list(self.state.sensing.numbers)
        for name, value in signals.items():
            numbers[self.robot.vocabulary.numbers.index(name)] = value
        sensing = self.state.sensing._replace(numbers=tuple(numbers))
        self.state = self.state._replace(sensing=sensing)
        self.logs = [log.message for log in self.companion.look(self.state, now_s)]
        return list(self.companion.speak(now_s))

    def word(self, now_s: float, **signals: float) -> str:
        """Look beyond the bend; return the word that is said, and one that is due in brackets."""
        self.front_m = 1.35
        said = self.shows(now_s, **signals)
        words = [event.word for event in said if isinstance(event, DetectorWord)]
        return words[0] if words else f"({self.companion._detector.due})"

    def announced(self, *, in_bend: bool) -> None:
        self.state = self.state._replace(surveyed=self.state.surveyed._replace(in_bend=in_bend))


def test_belief_in_a_passed_bend_needs_a_shape_that_fits_in_four_looks() -> None:
    reckoning, said = Reckoning(), []
    shapes: list[Shape] = ["fits", "fits", "unknown", "fits", "fits", "fits", "fits", "fits"]
    reckoning.is_straight = False
    for number, reckoning.shape in enumerate(shapes):
        said.append(reckoning.word(0.1 * number))
        reckoning.is_straight, reckoning.way_m = True, 1.0

    assert said == ["(past)"] * 6 + ["past", "(past)"]
    fresh = Reckoning()
    assert [fresh.word(0.1 * step) for step in range(4)] == ["(past)"] * 3 + ["past"]


def test_belief_in_a_passed_bend_needs_a_way_that_was_rolled_straight_too() -> None:
    reckoning, said = Reckoning(), []
    for number in range(8):
        reckoning.is_straight, reckoning.way_m = number > 5, 0.1 * number
        said.append(reckoning.word(0.1 * number))

    assert said == ["(past)"] * 6 + ["past", "(past)"]


@pytest.mark.parametrize(("diameters", "said"), [((0, 1), "(past)"), ((0, -1), "past")])
def test_a_robot_that_measures_no_diameter_shows_no_shape(
    diameters: tuple[int, int], said: str
) -> None:
    robot = load(Order("mitre_bend")).robot
    parts = (vee._replace(diameter=at) for vee, at in zip(robot.body.parts, diameters, strict=True))
    reckoning = Reckoning(replace(robot, body=replace(robot.body, parts=tuple(parts))))
    reckoning.shape = "contradicts"

    assert reckoning.word(0.0) == said


BENT = dict.fromkeys(("gamma_1", "gamma_2", "gamma_3", "gamma_4"), radians(10))
STRAIGHT = dict.fromkeys(BENT, 0.0)


@pytest.mark.parametrize("stiff", ["", *BENT])
def test_belief_in_a_passed_bend_needs_joints_that_have_moved_in_it(stiff: str) -> None:
    reckoning = Reckoning()
    reckoning.front_m = 0.95
    for step in range(3):  # the first word is said, the bend is announced
        reckoning.shows(0.1 * step, **STRAIGHT)
    reckoning.announced(in_bend=True)
    reckoning.shows(0.3, **STRAIGHT)
    reckoning.shows(0.4, **BENT | ({stiff: radians(9)} if stiff else {}))
    reckoning.shows(0.5, **dict.fromkeys(BENT, nan))
    for step in range(6, 11):
        said = reckoning.word(0.1 * step, **STRAIGHT)
        if said == "past":
            break

    assert said == ("(past)" if stiff else "past")
    if stiff:
        assert reckoning.companion.reckoned.shape == "contradicts"
        misfit = reckoning.companion._misfit(reckoning.companion.reckoned, [])
        assert misfit == f"{stiff} has not moved in the bend"
        reckoning.announced(in_bend=False)
        assert [reckoning.word(2.0 + 0.1 * step) for step in range(4)][-1] == "past"


@pytest.mark.parametrize(("least_deg", "passed"), [(5, True), (9, False)])
def test_joints_move_in_a_bend_by_what_is_between_their_least_and_largest_angle(
    least_deg: float, passed: bool
) -> None:
    """They begin in it before the next word is due, and move on while it is."""
    reckoning = Reckoning()
    reckoning.announced(in_bend=True)
    for front_m, angle_deg in ((0.95, 16), (1.2, least_deg), (1.25, 16)):
        reckoning.front_m = front_m
        reckoning.shows(front_m, **dict.fromkeys(BENT, radians(angle_deg)))

    assert ("past" in [reckoning.word(2.0 + 0.1 * step) for step in range(4)]) is passed


def test_of_a_bend_in_which_it_began_nobody_knows_how_the_joints_moved() -> None:
    reckoning = Reckoning()
    reckoning.announced(in_bend=True)
    reckoning.front_m = 1.15
    reckoning.shows(0.0, **STRAIGHT)
    assert "past" in [reckoning.word(0.1 * step, **STRAIGHT) for step in range(1, 5)]


@pytest.mark.parametrize(
    ("lying", "misfit"),
    [
        ((0,), "rear_diameter shows 101 mm where it has 120 mm"),
        ((1,), "front_diameter shows 102 mm where it has 120 mm"),
        ((0, 1), "a wheel would be in a wall, or its parts do not lie along one axis"),
    ],
)
def test_what_does_not_fit_the_pipe_is_named(lying: Sequence[int], misfit: str) -> None:
    reckoning = Reckoning()
    reckoning.lying = lying
    names, numbers = list(reckoning.robot.vocabulary.numbers), [nan] * 60
    for part, shown_m in zip(reckoning.robot.body.parts, (0.102, 0.101), strict=True):
        numbers[part.diameter] = shown_m
        misfit = misfit.replace(
            ("front", "rear")[part.wheels[0] > 0] + "_diameter", names[part.diameter]
        )

    assert reckoning.companion._misfit(reckoning.reckoned, numbers) == misfit


def test_it_reckons_from_the_pipes_start_by_what_was_rolled_and_felt() -> None:
    loaded = load(Order("mitre_bend"))
    start = loaded.pipe.start.model_copy(update={"roll": 0.25})
    reckoning = Reckoning(pipe=loaded.pipe.model_copy(update={"start": start}))
    felt = reckoning.state.surveyed.reported._replace(roll_rad=0.5)
    surveyed = reckoning.state.surveyed._replace(part=1, reported=felt)
    reckoning.state = reckoning.state._replace(surveyed=surveyed)
    reckoning.way_m = 0.125
    reckoning.shows(0.0)
    reckoning.shows(0.1)

    names = [name for name, *_ in reckoning.asked]
    assert names == ["odometer", "begin", "odometer", "look"]
    (_, state, now_s, every), (_, first_m, numbers, held, roll_rad) = reckoning.asked[:2]
    assert (state, now_s, every) == (reckoning.asked[0][1], 0.0, (0, 1, 2, 3, 4, 5))
    assert (first_m, numbers[reckoning.robot.odometry]) == (pytest.approx(0.7), 0.125)
    assert (held, roll_rad) == (frozenset(), 0.25)
    assert reckoning.asked[2][2:] == (0.1, (3, 4, 5))
    assert reckoning.asked[3][3:] == (frozenset(), Felt(1, 0.5))


def test_a_pipe_without_a_start_says_nothing_of_the_roll() -> None:
    pipe = load(Order("mitre_bend")).pipe.model_copy(update={"start": None})
    reckoning = Reckoning(pipe=pipe)
    reckoning.shows(0.0)

    assert reckoning.asked[1][-1] == 0.0


@pytest.mark.parametrize("place", [0.0, 2.0])
def test_it_may_begin_at_either_end_of_the_pipe_and_its_odometer_be_any_signal(
    place: float,
) -> None:
    loaded = load(Order("mitre_bend"))
    robot = replace(loaded.robot, odometry=0)
    companion = Odometry(loaded.loaded_robot.profile, robot, loaded.pipe, place)

    assert companion.first_wheel_m == place


def test_it_warns_again_of_a_place_that_is_lost_after_it_was_known() -> None:
    reckoning, warnings = Reckoning(), []
    for now_s, silent, spots in (
        (0.99, [0], {}),
        (1.0, [0], {}),
        (1.1, [0], {}),
        (1.2, [], reckoning.spots),
        (1.3, [], {}),
        (2.19, [5], {}),
        (2.3, [5], {}),
        (2.4, [5], {}),
    ):
        reckoning.silent, reckoning.spots = silent, spots
        reckoning.shows(now_s)
        warnings += [(now_s, message) for message in reckoning.logs]

    silent, lost = (
        "does not know yet where the robot is",
        "has lost the robot's place while the hold changed",
    )
    assert warnings == [
        (1.0, f"odometry {silent}: gamma_1 unknown; it says no word"),
        (1.3, f"odometry {lost}; it says no word"),
    ]


@pytest.mark.parametrize(
    ("after_s", "found", "lost"),
    [(0.9, False, False), (1.0, False, True), (0.9, True, False), (1.0, True, False)],
)
def test_a_place_that_is_lost_while_the_hold_changes_stays_for_a_moment(
    after_s: float, found: bool, lost: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    reckoning = Reckoning()
    reckoning.shows(5.0)
    known = reckoning.companion.reckoned
    nowhere = known._replace(spots={})
    again = known._replace(anchor=0)
    answers = iter([nowhere, known, again if found else nowhere])
    asked: list[tuple[Any, ...]] = []

    def look(*given: Any) -> Reckoned:
        asked.append(given)
        return next(answers)

    monkeypatch.setattr(reckoning.companion, "_reckoner", SimpleNamespace(look=look))
    held, numbers, felt = frozenset({0}), [1.0], Felt(1, 0.5)
    before = known._replace(spots={-1: AnchorSpot(0.5, 0.0), 1: AnchorSpot(0.4, 0.0)})

    after = reckoning.companion._follow(before, numbers, held, felt, 5.0 + after_s)

    assert after.lost is lost
    assert lost or after is (again if found else known)
    assert asked == [
        (before, numbers, held, felt),
        (before, numbers, frozenset({1})),
        (known, numbers, held),
    ]


def test_the_moment_in_which_a_place_is_kept_begins_when_it_was_known_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reckoning = Reckoning()
    reckoning.shows(5.0)
    reckoning.shows(5.8)
    known = reckoning.companion.reckoned
    looks = iter([known._replace(spots={}), known, known._replace(spots={})])
    monkeypatch.setattr(
        reckoning.companion, "_reckoner", SimpleNamespace(look=lambda *_: next(looks))
    )

    assert reckoning.companion._follow(known, [], frozenset({0}), Felt(1, 0.5), 6.7) is known


def test_a_fault_of_the_place_is_said_with_the_words() -> None:
    reckoning = Reckoning()
    reckoning.shape = "contradicts"
    reckoning.word(0.0)
    reckoning.way_m = 0.13
    reckoning.front_m = 1.35
    events = reckoning.shows(0.1)

    assert [event.code for event in events if isinstance(event, FaultReport)] == [
        "place.contradicted"
    ]
    assert reckoning.companion.speak(0.2) == ()


def test_where_it_is_in_a_round_pipe_is_shown_with_its_rolls() -> None:
    loaded = load(Order("mitre_bend"))
    reckoning = Reckoning(pipe=loaded.pipe.model_copy(update={"section": "round"}))
    reckoning.companion.first_wheel_m = 0.2
    reckoning.shows(0.0)

    shown = reckoning.companion.truth()
    assert shown.distance_m == pytest.approx(0.3)
    assert shown.z_m == (0.02,) * 6
    assert shown.rolls_rad == pytest.approx((-0.1, 0.3, 0.4))
    assert reckoning.companion._front_roll_rad() == 0.3


def test_between_bars_the_plane_of_the_pipe_is_the_robots() -> None:
    loaded = load(Order("mitre_bend"))
    reckoning = Reckoning(pipe=loaded.pipe.model_copy(update={"roll": 0.4}))
    reckoning.shows(0.0)

    assert reckoning.companion._front_roll_rad() == -0.4
    assert reckoning.companion.truth().rolls_rad == ()


def test_what_was_rolled_before_a_restart_counts_on() -> None:
    reckoning = Reckoning()
    companion = reckoning.companion
    companion.restart(reckoning.robot)
    assert companion.reckoned is None

    companion.reckoned = reckoning.reckoned._replace(odometer_m=0.5)
    companion._bent_m, companion._doubted_m = 0.45, 0.4
    companion.restart(reckoning.robot)

    assert companion.reckoned.odometer_m == 0.0
    assert (companion._bent_m, companion._doubted_m) == pytest.approx((-0.05, -0.1))


def rest_s(reckoning: Reckoning, now_s: float = 1.0) -> float:
    """After what time it looks again, once no command is on its way."""
    body = reckoning.state.robot._replace(flight=None)
    reckoning.state = reckoning.state._replace(robot=body)
    reckoning.shows(now_s)
    return reckoning.companion.due_s - now_s


@pytest.mark.parametrize(
    ("front_m", "rest", "why"),
    [
        (0.97, 0.15, "nothing is near"),
        (0.93, 0.05, "a word begins 10 mm on"),
        (0.99, 0.1 / 1.512, "a joint is 10 mm on"),
        (1.24, 0.1 / 1.512, "the last wheel has passed it by 10 mm"),
        (1.4, 0.15, "the bend is passed"),
    ],
)
def test_looks_are_seldom_unless_a_wheel_is_near_to_what_changes_the_report(
    front_m: float, rest: float, why: str
) -> None:
    reckoning = Reckoning()
    reckoning.front_m = front_m
    for step in range(4):
        found = rest_s(reckoning, 1.0 + 0.1 * step)

    assert found == pytest.approx(rest, abs=1e-3), why


def test_looks_are_seldom_wherever_a_robot_stands() -> None:
    reckoning = Reckoning()
    reckoning.front_m = 0.99
    values = (0.0,) * len(reckoning.state.robot.values)
    reckoning.state = reckoning.state._replace(
        robot=reckoning.state.robot._replace(values=values, flight=None)
    )

    assert rest_s(reckoning) == pytest.approx(0.15)


def test_it_looks_often_while_a_command_is_on_its_way_or_the_place_of_a_wheel_is_unknown() -> None:
    reckoning = Reckoning()
    reckoning.front_m = 0.97
    reckoning.shows(1.0)
    assert reckoning.state.robot.flight is not None
    assert reckoning.companion.due_s == pytest.approx(1.05)
    reckoning.hidden = 1
    assert rest_s(reckoning) == pytest.approx(0.05)


def test_it_looks_often_while_a_word_waits_for_the_shape() -> None:
    reckoning = Reckoning()
    reckoning.front_m, reckoning.shape = 1.4, "contradicts"

    assert rest_s(reckoning) == pytest.approx(0.05)


STATES = StateChange(("Held",), ())


@pytest.mark.parametrize(
    ("effects", "soon"),
    [
        ([Log("info", "x"), CommandStatus("DriveForward", "sent")], True),
        ([STATES], True),
        ([Setpoints(2, ())], True),  # they stop the wheels, which are driven
        ([Setpoints(2, (1.0,)), Log("info", "x")], False),
        ([], False),
    ],
)
def test_it_looks_soon_where_an_effect_shows_that_the_robot_may_move_otherwise(
    effects: list[Effect], soon: bool
) -> None:
    reckoning = Reckoning()
    reckoning.front_m = 0.97
    rest_s(reckoning)
    still, driven = (0.0,) * len(reckoning.state.robot.values), reckoning.state.robot.values
    sent: list[Effect] = [
        each._replace(values=driven if each.values else still)
        if isinstance(each, Setpoints)
        else each
        for each in effects
    ]

    reckoning.companion.react(sent, 1.02)
    assert reckoning.companion.due_s == pytest.approx(1.07 if soon else 1.15)
    reckoning.companion.react([STATES], 1.12)
    assert reckoning.companion.due_s == pytest.approx(1.07 if soon else 1.15), "never later"
