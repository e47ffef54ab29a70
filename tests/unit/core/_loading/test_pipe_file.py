"""Pipes: what can be built and clamped, and what is said of the others."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pirate_sm.core._loading.pipe import check_pipe, load_pipe, reach
from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.robot.loader import load_robot

ROOT = Path(__file__).resolve().parents[4]
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
    said = faults(mission("p.yaml"), {"p.yaml": f"diameter: 200 mm\nformat: 1\n{STRAIGHT}\n"})

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
        ("segments: [{strait: 1 m}]", "4:38: expected a segment, {straight: 1.0 m},"),
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


HOUSE = """format: 1
diameter: 120 mm
section: round
runs:
  main: {from: entry, to: t1, segments: [{straight: 1 m}]}
  past: {from: t1.on, to: cap, segments: [{straight: 2 m}]}
  branch: {from: t1.branch, to: exit, diameter: 110 mm, segments: [{straight: 1 m}]}
junctions: {t1: {tee: 90 deg}}
ends: {entry: open, cap: closed, exit: open}
routes: {house: [main, branch], past: [main, past]}
start: {run: main, at: 600 mm}
"""


def test_a_network_is_read_and_followed(tmp_path):
    path = tmp_path / "house.yaml"
    path.write_text(HOUSE, "utf-8")

    pipe, _ = load_pipe(path)

    assert pipe.route().crossings_m == (1.0,)
    assert pipe.along("past").route().crossings_m == ()
    assert pipe.network().closed == {"cap"}
    assert pipe.start_of(0.458) == 0.6
    assert pipe.route() is pipe.route()
    assert pipe.model_copy(update={"diameter": 0.1}).route().diameter_at(0.0) == 0.1
    assert pipe.diameter_at_start(0.458) == 0.12


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("from: t1.on", "from: t2.on", "6:16: there is no junction or end 't2'"),
        ("from: t1.on", "from: t1.branch", "7:18: more than one run begins or ends at 't1.branch'"),
        ("from: t1.on", "from: t1.off", "6:16: the text 't1.off' does not fit"),
        ("to: cap, ", "to: nowhere, ", "6:27: there is no junction or end 'nowhere'"),
        ("cap: closed, ", "cap: shut, ", "9:26: expected one of"),
        ("cap: closed, ", "cap: closed, lid: open, ", "9:34: no run begins or ends at 'lid'"),
        ("tee: 90 deg", "tee: 45 deg", "8:23: expected 90 deg, got 45 deg"),
        ("[main, branch]", "[main, brnch]", "10:24: there is no run 'brnch'"),
        ("[main, branch]", "[branch, past, main]", "10:17: run 'main' does not begin or end at"),
        ("[main, branch]", "[main, main]", "10:24: the route passes the run 'main' twice"),
        ("run: main", "run: past", "11:14: the first route does not lead through 'past'"),
        ("at: 600 mm", "at: 1.2 m", "11:24: 1.2 m is beyond the end of the pipe"),
        ("110 mm", "125 mm", "7:18: 125 mm here is wider than the run of the tee 't1'"),
        ("to: cap, ", "to: cap, diameter: 110 mm, ", "6:16: 110 mm here has another diameter"),
        ("section: round\n", "", "4:3: a network of runs needs a round pipe"),
        ("routes: {house: [main, branch], past: [main, past]}\n", "",
         "4:1: a network of several runs needs a route"),
        ("[{straight: 2 m}]", "[{straight: 2 m}, {elbow: 90 deg, radius: 50 mm}, {straight: 1 m}]",
         "6:84: the inner wall of this elbow folds"),
        ("[{straight: 2 m}]", "[{straight: 2 m}, {reducer: 60 mm, to: 120 mm}, {straight: 1 m}]",
         "6:81: the pipe has 120 mm already"),
        ("[{straight: 2 m}]", "[{straight: 0.2 m}, {mitre: 120 deg}, {straight: 1 m}]",
         "7:68: this runs into segment 3 of the run 'past'"),
        ("runs:", "segments: [{straight: 1 m}]\nruns:", "5:1: a pipe has either"),
        ("start:", "segments: [{straight: 1 m}]\nstart:", "11:1: a pipe has either"),
        ("start:", "frame: {}\ntilt: 3 deg\nstart:", "12:1: a pipe has either `frame`"),
        ("start:", "patches: [{from: 1 m, to: 2 m, static: 1, kinetic: 1}]\nstart:",
         "11:1: the patches of a pipe with `runs`"),
    ],
)  # fmt: skip
def test_a_network_that_cannot_be_built_is_refused_with_its_place(tmp_path, old, new, fault):
    assert old in HOUSE
    path = tmp_path / "house.yaml"
    path.write_text(HOUSE.replace(old, new, 1), "utf-8")
    try:
        pipe, document = load_pipe(path)
    except LoadError as error:
        found = [str(each) for each in error.problems]
    else:
        problems = Problems(document)
        check_pipe(pipe, document, problems)
        found = [str(each) for each in problems.errors]

    assert any(f"house.yaml:{fault}" in each for each in found), found


@pytest.mark.parametrize(
    ("rest", "fault"),
    [
        ("", "1:1: a pipe has either `segments` or `runs`"),
        ("runs: {}\n", "4:1: there is no run here"),
        (
            "segments: [{straight: 1 m}]\nroutes: {a: [b]}\n",
            "5:1: `junctions`, `ends` and `routes`",
        ),
    ],
)
def test_what_a_pipe_consists_of_is_asked_for_at_its_key(tmp_path, rest, fault):
    path = tmp_path / "a.yaml"
    path.write_text(f"format: 1\npipe: a\ndiameter: 120 mm\n{rest}", "utf-8")
    with pytest.raises(LoadError) as caught:
        load_pipe(path)

    assert f"a.yaml:{fault}" in str(caught.value)


def test_every_bad_route_is_named(tmp_path):
    path = tmp_path / "house.yaml"
    routes = "{a: [mian, branch], b: [branch, past, main], c: [main, main], house: [main, branch]}"
    whole = HOUSE.replace("{house: [main, branch], past: [main, past]}", routes)
    path.write_text(whole.replace("run: main", "run: past"), "utf-8")
    pipe, document = load_pipe(path)
    problems = Problems(document)
    check_pipe(pipe, document, problems)

    assert [each.message for each in problems.errors] == [
        "there is no run 'mian'",
        "run 'main' does not begin or end at 'cap'",
        "the route passes the run 'main' twice",
    ]


def test_a_port_that_a_tee_does_not_have_is_described_in_words(tmp_path):
    path = tmp_path / "house.yaml"
    path.write_text(HOUSE.replace("from: t1.branch", "from: t1.brunch", 1), "utf-8")

    with pytest.raises(LoadError, match=r"expected an end, .* such as t1\.on or t1\.branch"):
        load_pipe(path)


@pytest.mark.parametrize(
    "segment",
    ["{elbow: 90 deg, radius: 180 mm}", "{reducer: 60 mm, to: 100 mm}",
     "{mitre: 90 deg, roll: 1 deg}", "{tee: 90 deg, take: on}"],
)  # fmt: skip
def test_what_leaves_the_plane_needs_a_round_pipe(faults, segment):
    pipe = f"{{diameter: 120 mm, segments: [{{straight: 1 m}}, {segment}, {{straight: 1 m}}]"

    (said,) = faults(mission(pipe + "}"))
    assert "needs a round pipe: add `section: round`" in said
    assert faults(mission(pipe + ", section: round}")) == []


def test_a_tee_in_a_list_of_segments_is_a_network(tmp_path):
    path = tmp_path / "t.yaml"
    text = (
        "format: 1\ndiameter: 120 mm\nsection: round\n"
        "segments: [{straight: 1 m}, {reducer: 60 mm, to: 100 mm},"
        " {straight: 1 m}, {tee: 90 deg, roll: 90 deg, take: branch, stub: 0.4 m, diameter: 80 mm},"
        " {straight: 1 m}, {tee: 90 deg, take: on}, {straight: 1 m}]\n"
    )
    path.write_text(text, "utf-8")

    route = load_pipe(path)[0].route()

    assert [joint.kind for joint in route.joints] == ["reducer", "tee", "tee"]
    assert route.crossings_m == pytest.approx((2.06,))
    assert [route.diameter_at(arc) for arc in (0.5, 1.5, 2.5, 3.5)] == [0.12, 0.1, 0.08, 0.08]
    assert route.network.closed == {"cap_1", "cap_2"}
    assert route.network.runs["stub_1"].segments[0].length_m == 0.4


def test_segments_and_patches_have_friction_along_the_route(tmp_path):
    path = tmp_path / "h.yaml"
    text = HOUSE.replace(
        "[{straight: 1 m}]}\njunc",
        "[{straight: 1 m, friction: {static: 0.3, kinetic: 0.2}}], patches: []}\njunc",
    ).replace(
        "[{straight: 1 m}]}\n  past",
        "[{straight: 1 m}],"
        " patches: [{from: 0.1 m, to: 0.2 m, static: 0.4, kinetic: 0.2}]}\n  past",
    )
    path.write_text(text, "utf-8")
    pipe, _ = load_pipe(path)

    found = [
        (each.from_m, each.to_m, each.friction.static) for each in pipe.stretches(pipe.route())
    ]

    assert found == [(0.1, 0.2, 0.4), (1.0, 2.0, 0.3)]


def test_a_branch_wider_than_its_run_is_reported_at_its_entry(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    tee = "{tee: 90 deg, take: branch, diameter: 150 mm}"
    file.write_text(
        "format: 1\ndiameter: 120 mm\nsection: round\nsegments:\n  - {straight: 1 m}\n"
        f"  - {tee}\n  - {{straight: 1 m}}\n"
    )
    pipe, document = load_pipe(file)
    problems = Problems(document)
    check_pipe(pipe, document, problems)
    with pytest.raises(LoadError, match=r":6:43: a branch of 150 mm is wider than its run"):
        problems.raise_errors()
