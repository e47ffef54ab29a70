"""Pipes: what can be built and clamped, and what is said of the others."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pirate_sm.loading.pipe_file import load_pipe, reach
from pirate_sm.loading.problems import LoadError
from pirate_sm.loading.robot import load_robot

ROOT = Path(__file__).resolve().parents[3]
PIPES = [
    *sorted((ROOT / "sequences" / "pipes").glob("*.yaml")),
    ROOT / "tests" / "robots" / "newt" / "elbow.yaml",
]
STRAIGHT = "segments: [{straight: 1 m}]"


def mission(pipe: str) -> str:
    return (
        f"format: 1\nmission: m\nrobot: pirate_ii\npipe: {pipe}\n"
        "start: a\nphases: {a: {go: e}}\nends: {e: {succeed: ok}}\n"
    )


@pytest.mark.parametrize("path", PIPES, ids=lambda path: path.stem)
def test_a_shipped_pipe_loads(path):
    pipe, document = load_pipe(path)

    assert pipe.diameter > 0
    assert document.name


def test_the_reach_leaves_a_folded_v_room_before_its_end_stop():
    least, largest = reach(load_robot(ROOT / "hardware_profiles" / "pirate_ii").profile)

    assert least == pytest.approx(0.048)
    assert largest == pytest.approx(
        0.09 * math.sin(math.radians((120 - 10) / 2)) + 0.048
    )  # eq. 3-2


@pytest.mark.parametrize(
    ("diameter", "fits"),
    [("48 mm", False), ("49 mm", True), ("120 mm", True), ("121.7 mm", True), ("122 mm", False)],
)
def test_a_pipe_fits_within_the_reach(faults, diameter, fits):
    said = faults(mission(f"{{diameter: {diameter}, {STRAIGHT}}}"))

    assert (said == []) is fits


def test_a_pipe_that_does_not_fit_is_told_with_both_numbers(load):
    with pytest.raises(LoadError) as caught:
        load(mission(f"{{diameter: 200 mm, {STRAIGHT}}}"))

    assert "m.yaml:4:18: pirate_ii cannot clamp an inner diameter of 200 mm" in str(caught.value)
    assert "expected more than 48 mm and at most 121.7 mm" in str(caught.value)


def test_a_pipe_in_which_most_bends_failed_is_refused_with_both_numbers(faults, load):
    with pytest.raises(LoadError) as caught:
        load(mission(f"{{diameter: 124 mm, {STRAIGHT}}}"))

    assert "cannot clamp an inner diameter of 124 mm" in str(caught.value)
    assert "at most 121.7 mm" in str(caught.value)
    assert "10 deg before its end stop" in str(caught.value)


def test_a_pipe_from_a_file_is_told_with_its_own_place(faults):
    said = faults(mission("p.yaml"), {"p.yaml": f"diameter: 200 mm\n{STRAIGHT}\n"})

    assert said == ["p.yaml:1:11: pirate_ii cannot clamp an inner diameter of 200 mm"]


@pytest.mark.parametrize(
    ("rest", "fault"),
    [
        ("segments: []", "4:36: this is empty"),
        ("segments: [{mitre: 90 deg}, {straight: 1 m}]", "4:37: a pipe begins and ends with a"),
        ("segments: [{straight: 1 m}, {mitre: 90 deg}]", "4:54: a pipe begins and ends with a"),
        ("segments: [{straight: 1 m}, {mitre: 90 deg}, {mitre: 9 deg}, {straight: 1 m}]",
         "4:71: between two mitres there is a straight"),
        ("segments: [{straight: 1 m}, {mitre: 0 deg}, {straight: 1 m}]",
         "4:62: a mitre turns by more than 0 deg"),
        ("segments: [{straight: 1 m}, {mitre: 130 deg}, {straight: 1 m}]",
         "4:62: expected at most 120 deg, got 130 deg"),
        ("segments: [{straight: 1 m}, {mitre: 90}, {straight: 1 m}]", "4:62: expected an angle"),
        ("segments: [{straight: 1 m}, {mitre: 90 mm}, {straight: 1 m}]",
         "4:62: expected an angle"),
        ("segments: [{straight: 1 m}, {mitre: 90 deg}, {straight: 50 mm}]",
         "4:82: the walls of its mitres meet in a straight of 50 mm"),
        ("segments: [{straight: 0 m}]", "4:48: expected more than 0 m"),
        ("segments: [{strait: 1 m}]", "4:37: expected a segment, {straight: 1.0 m} or"),
        (f"{STRAIGHT}, start: {{at: 2 m}}", "4:67: 2.0 m is beyond the end of the pipe"),
        (f"{STRAIGHT}, start: {{at: -1 m}}", "4:67: expected at least 0 m"),
        (f"{STRAIGHT}, blockages: [{{at: 2 m, lasting: 1 s}}]", "4:72: 2.0 m is beyond the end"),
        (f"{STRAIGHT}, blockages: [{{at: 2 m, lasting: -1 s}}]", "4:86: expected at least 0 s"),
        (f"{STRAIGHT}, friction: {{static: 0.1, kinetic: 0.5}}", "4:55: kinetic friction cannot"),
        (f"{STRAIGHT}, tilt: 100 deg", "4:61: expected at most 90 deg, got 100 deg"),
        (f"{STRAIGHT}, tilt: -400 deg", "4:61: expected at least -90 deg, got -400 deg"),
        (f"{STRAIGHT}, roll: 181 deg", "4:61: expected at most 180 deg, got 181 deg"),
        (f"{STRAIGHT}, section: oval", "4:64: expected one of"),
        (f"{STRAIGHT}, turns: {{from: 5 s, to: 5 s, tilt: 90 deg}}", "4:55: `to` must be later"),
        (f"{STRAIGHT}, turns: {{from: 5 s, to: 9 s, tilt: 100 deg}}", "4:89: expected at most 90"),
        (f"{STRAIGHT}, turns: {{from: 5 s, to: 9 s}}", "4:55: the key 'tilt' is missing"),
        (f"{STRAIGHT}, patches: [{{from: 0.2 m, to: 2 m, static: 0.2, kinetic: 0.1}}]",
         "4:83: 2.0 m is beyond the end of the pipe"),
        (f"{STRAIGHT}, patches: [{{from: 0.5 m, to: 0.4 m, static: 0.2, kinetic: 0.1}}]",
         "4:83: the patch ends at or before 500 mm"),
        (f"{STRAIGHT}, patches: [{{from: 0 m, to: 0.4 m, static: 0.2, kinetic: 0.1}}, "
         "{from: 0.3 m, to: 0.6 m, static: 0.2, kinetic: 0.1}]",
         "4:123: 300 mm lies in another patch"),
        (f"{STRAIGHT}, patches: [{{from: 0.5 m, to: 0.6 m, static: 0.1, kinetic: 0.2}}]",
         "4:65: kinetic friction cannot"),
        (f"{STRAIGHT}, tilts: 10 deg", "4:55: unknown key 'tilts'"),
    ],
)  # fmt: skip
def test_a_pipe_that_cannot_be_built_is_refused_with_its_place(faults, rest, fault):
    said = faults(mission(f"{{diameter: 120 mm, {rest}}}"))

    assert [each for each in said if each.startswith(f"m.yaml:{fault}")], said


def bends(*rest: str) -> str:
    """A pipe of straights, `0.3 m`, and mitres, `90 deg`."""
    kinds = [f"{{{'mitre' if each.endswith('deg') else 'straight'}: {each}}}" for each in rest]
    return f"{{diameter: 120 mm, segments: [{', '.join(kinds)}]}}"


@pytest.mark.parametrize(
    ("segments", "into"),
    [
        (("1 m", "90 deg", "0.3 m", "90 deg", "0.3 m", "90 deg", "1 m"), 1),
        (("1 m", "120 deg", "0.4 m", "120 deg", "1 m"), 1),
        (("0.5 m", "0.5 m", "-90 deg", "0.3 m", "-90 deg", "0.3 m", "-90 deg", "1 m"), 1),
        (("1 m", "45 deg", "1 m", "90 deg", "0.3 m", "90 deg", "0.3 m", "90 deg", "1 m"), 3),
    ],
)
def test_a_pipe_that_runs_into_itself_is_refused(faults, segments, into):
    said = faults(mission(bends(*segments)))

    assert len(said) == 1
    assert said[0].endswith(f"this runs into segment {into} of the same pipe")


@pytest.mark.parametrize(
    "segments",
    [
        ("1 m", "90 deg", "0.13 m", "90 deg", "1 m"),
        ("1 m", "90 deg", "0.13 m", "-90 deg", "1 m"),
        ("1 m", "30 deg", "0.05 m", "-30 deg", "1 m"),
        ("1 m", "90 deg", "1 m", "90 deg", "0.5 m", "90 deg", "0.8 m"),
    ],
)
def test_a_pipe_that_keeps_clear_of_itself_is_taken(faults, segments):
    assert faults(mission(bends(*segments))) == []
