"""Maps as pipe files."""

from __future__ import annotations

from math import degrees, inf, nan, pi, radians

import pytest

from pirate_sm.core._model.pipe_runs import Elbow, InlineTee, Mitre, Reducer
from pirate_sm.core.documents import Problems, parse_document
from pirate_sm.core.loading import check_pipe, validate
from pirate_sm.core.models import Pipe, Straight
from pirate_sm.lab.mapping.legs import Bore, Leg, Map, MappedBend
from pirate_sm.lab.mapping.pipe_text import pipe_text


def leg(begins_m: float, ends_m: float, reached: tuple[float, float], diameter_m: float) -> Leg:
    bores = [Bore(at / 100, at / 100 + 0.1, diameter_m) for at in range(0, 30)]
    return Leg(begins_m, ends_m, bores=bores, reached_m=reached)


def two_legs(bend: MappedBend, diameters: tuple[float, float] = (0.12, 0.12)) -> Map:
    first = leg(-inf, 0.8, (-0.2, 0.7), diameters[0])
    second = leg(0.0, inf, (0.1, 0.6), diameters[1])
    return Map([first, second], [bend], (0, 0.1), 0.0, 0.0)


def read(made: Map) -> tuple[Pipe, str]:
    text = pipe_text(made, "found", "run.mcap")
    document = parse_document(text, "found.yaml")
    pipe, problems = validate(document, Pipe), Problems(document)
    check_pipe(pipe, document, problems)
    assert not problems.errors
    return pipe, text


@pytest.mark.parametrize(("roll", "mitre"), [(0.0, 60), (radians(1), 60), (pi, -60)])
def test_a_bend_in_the_robots_plane_is_one_between_bars(roll: float, mitre: float) -> None:
    pipe, text = read(two_legs(MappedBend(radians(60), roll)))
    assert pipe.segments is not None
    first, bend, second = pipe.segments
    assert first == Straight(straight=1.0)
    assert isinstance(bend, Mitre)
    assert degrees(bend.mitre) == pytest.approx(mitre)
    assert second == Straight(straight=0.6)
    assert pipe.section == "bars"
    assert pipe.start is not None
    assert pipe.start.at == pytest.approx(0.3)
    assert "A mitre or an elbow" in text


def test_a_bend_out_of_the_robots_plane_needs_a_round_pipe() -> None:
    pipe, _ = read(two_legs(MappedBend(pi / 2, pi / 2)))
    assert pipe.section == "round"
    assert pipe.segments is not None
    bend = pipe.segments[1]
    assert isinstance(bend, Mitre)
    assert degrees(bend.roll) == pytest.approx(90)


def test_a_tee_is_one_that_a_word_has_announced() -> None:
    pipe, text = read(two_legs(MappedBend(radians(88), 0.0, "tee")))
    assert pipe.segments is not None
    assert isinstance(pipe.segments[1], InlineTee)
    assert "The length of the arm straight on is not known." in text


@pytest.mark.parametrize(("felt", "sure"), [(True, "from gravity"), (False, "15 deg only")])
def test_an_elbow_is_written_as_one_in_a_round_pipe(felt: bool, sure: str) -> None:
    elbow = MappedBend(radians(88), 0.0, extent_m=0.15, radius_m=0.17, felt=felt)
    pipe, text = read(two_legs(elbow))
    assert pipe.section == "round"
    assert pipe.segments is not None
    found = pipe.segments[1]
    assert isinstance(found, Elbow)
    assert (degrees(found.elbow), found.radius) == pytest.approx((88, 0.17))
    assert sure in text


def test_the_start_behind_an_elbow_counts_its_length() -> None:
    made = two_legs(MappedBend(pi / 2, 0.0, extent_m=0.15, radius_m=0.17))
    made.start = (1, 0.3)
    pipe, _ = read(made)
    assert pipe.start is not None
    assert pipe.start.at == pytest.approx(1.0 + 0.17 * pi / 2 + 0.3, abs=0.001)


def test_a_start_at_the_end_of_the_pipe_is_still_in_it() -> None:
    made = two_legs(MappedBend(pi / 2, 0.0))
    made.legs[0].ends_m, made.legs[1].reached_m = 0.80004, (0.1, 0.60004)
    made.start = (1, 0.60004)
    read(made)


def test_a_corner_that_words_tell_of_is_no_long_elbow() -> None:
    _, text = read(two_legs(MappedBend(pi / 2, 0.0, extent_m=0.005)))
    assert "A mitre, a short elbow or a tee's branch" in text


def test_another_diameter_behind_a_bend_is_a_reducer_of_unknown_place() -> None:
    pipe, text = read(two_legs(MappedBend(pi / 2, 0.0), (0.12, 0.11)))
    assert pipe.segments is not None
    (narrows,) = (each for each in pipe.segments if isinstance(each, Reducer))
    assert narrows.to == pytest.approx(0.11)
    assert "Its place and length are not known" in text


@pytest.mark.parametrize(
    ("pitch", "roll", "tilt", "uphill"), [(90, 0, 90, 0), (0, 28, 28, 90), (-90, 0, 90, 180)]
)
def test_gravity_is_as_it_was_felt(pitch: float, roll: float, tilt: float, uphill: float) -> None:
    made = two_legs(MappedBend(pi / 2, 0.0))
    made.pitch_rad, made.roll_rad = radians(pitch), radians(roll)
    pipe, _ = read(made)
    assert degrees(pipe.tilt) == pytest.approx(tilt, abs=0.1)
    assert degrees(pipe.uphill) % 360 == pytest.approx(uphill, abs=0.1)


def test_gravity_that_was_never_felt_is_left_out() -> None:
    made = two_legs(MappedBend(pi / 2, 0.0))
    made.pitch_rad = nan
    pipe, text = read(made)
    assert pipe.tilt == 0.0
    assert "tilt" not in text
    assert "How it lies against gravity is not known." in text


def test_the_frames_of_legs_are_those_of_the_pipe_that_is_written() -> None:
    made = two_legs(MappedBend(radians(70), radians(50)))
    pipe, _ = read(made)
    ahead = pipe.route().pieces[-1].frame.ahead
    assert ahead == pytest.approx(made.frame(1).ahead, abs=2e-3)
