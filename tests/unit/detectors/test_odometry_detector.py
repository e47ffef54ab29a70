from __future__ import annotations

from itertools import pairwise
from math import nan, radians
from pathlib import Path

import pytest

from pirate_sm.companion import Onlooker
from pirate_sm.detectors.dead_reckoning import Reckoned, Shape, Spot
from pirate_sm.detectors.odometry_detector import Odometry
from pirate_sm.engine.robot.robot_state import LAPSED, Mark, confirmed_parts
from pirate_sm.errors import UsageError
from pirate_sm.geometry.chain_in_space import ChainInSpace
from pirate_sm.geometry.space import DRAWING
from pirate_sm.model.events import DetectorWord
from pirate_sm.runtime.first_choice import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.wiring import Order, prepare
from pirate_sm.wiring.prepared import Prepared

ROBOTS = Path(__file__).resolve().parents[2] / "robots"
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


@pytest.mark.parametrize("mission", ["mitre_bend", "mitre_bend_backward"])
def test_the_bend_is_passed_on_reckoning_alone(mission: str) -> None:
    result, places, truth = run(mission, detector="odometry")
    assert result.ended.outcome == "succeeded"
    assert places == pytest.approx(truth, abs=0.006)


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


@pytest.mark.parametrize("off_m", [0.015, -0.015])
def test_an_error_of_the_start_is_gone_behind_the_bend(off_m: float) -> None:
    _, places, truth = run("mitre_bend", detector="odometry", start_at_m=0.7 + off_m)
    assert places == pytest.approx(truth, abs=0.006)


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


THROUGH = frozenset({"through"})
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
    companion._detector._word = "through"
    looks = [Reckoned((), NOWHERE, odometer_m, 0, {}, 0.0, shape) for shape, odometer_m in course]

    faults = [companion._doubt(THROUGH, each, []) for each in looks]

    assert [number for number, fault in enumerate(faults) if fault is not None] == doubted
    for number in doubted:
        fault = faults[number]
        assert fault is not None
        assert fault.code == "place.contradicted"
        assert "odometry is where it would say 'through', but the robot does not fit" in (
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
    course: list[tuple[bool | None, float]], clear: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wheels slip round the bend: odometry may be ahead when the robot has just come straight."""
    companion, found = odometry(), []
    both = {0: Spot(2.0, 0.0), 1: Spot(1.8, 0.0)}
    for straight, odometer_m in course:  # None: one part alone holds, and the other may be anywhere
        spots = both if straight is not None else {0: both[0]}
        monkeypatch.setattr(companion._reckoner, "straight", lambda *_, known=straight: known)
        companion.reckoned = Reckoned((), NOWHERE, odometer_m, 0, spots, 0.0, "fits")
        found.append(companion._clear([]))

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
    assert min(gaps) == pytest.approx(0.5)
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

    assert companion._clear(run.state.sensing.numbers) == said
